// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grasp_set.hpp"

#include "support/temporary_folder.hpp"
#include "target.hpp"

#include <sstream>
#include <stdexcept>

namespace handover::fuzz {
namespace {

constexpr std::uint64_t kHash = 0x123456789abcdef0;

const test::TemporaryFolder& folder() {
  static const test::TemporaryFolder made;
  return made;
}

}  // namespace

std::vector<std::string> seeds() {
  GraspSet set{"cup", "gripper", "hand", {}, {}};
  Grasp grasp;
  grasp.open = Eigen::Vector2d(0.05, 0.5);
  grasp.closed = Eigen::Vector2d(0.01, 0.02);
  grasp.contacts = {{"left", {0.01, 0, 0}, {1, 0, 0}}, {"right", {-0.01, 0, 0}, {-1, 0, 0}}};
  grasp.quality = 0.25;
  set.grasps.push_back(grasp);
  const auto file = folder() / "seed.json";
  if (!writeGraspSet(set, kHash, file)) throw std::logic_error("no file for the seed");
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return {text.str()};
}

void run(std::string_view input) {
  const auto file = folder().write("set.json", std::string(input));
  const auto set = readGraspSet(file, kHash);
  if (set && set->grasps.empty() && set->none_because.empty()) {
    throw std::logic_error("an empty set says not why");
  }
}

}  // namespace handover::fuzz
