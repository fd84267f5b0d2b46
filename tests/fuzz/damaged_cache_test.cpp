// SPDX-License-Identifier: Apache-2.0
// Maps and grasp sets damaged at random (seeded): taken, or refused with an error that names the
// file.
#include "core/grasp/grasp_set.hpp"
#include "core/reachability/map_file.hpp"
#include "damage.hpp"
#include "support/arm_models.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <xxhash.h>

#include <cstring>
#include <fstream>
#include <sstream>

namespace handover::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kHash = 0x0123456789abcdefULL;

std::string contentOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

GraspSet twoGrasps() {
  GraspSet set{"cup", "gripper", "hand", {}, {}};
  for (const double quality : {0.3, 0.1}) {
    Grasp grasp;
    grasp.X_OT.translation() = Eigen::Vector3d(0.1, -0.2, quality);
    grasp.open = Eigen::Vector2d(0.05, 0.5);
    grasp.closed = Eigen::Vector2d(0.01, 0.02);
    grasp.contacts = {{"left", {0.01, 0, 0}, {1, 0, 0}}, {"right", {-0.01, 0, 0}, {-1, 0, 0}}};
    grasp.quality = quality;
    set.grasps.push_back(grasp);
  }
  return set;
}

TEST(DamagedCache, GraspSetIsRefusedOrTheSame) {
  const TemporaryFolder folder;
  const fs::path file = folder / "grasps.json";
  ASSERT_TRUE(writeGraspSet(twoGrasps(), kHash, file));
  const std::string good = contentOf(file);
  for (int seed = 1; seed <= fuzzRuns(2000); ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    const std::string text = damaged(good, generator);
    folder.write("grasps.json", text);
    const auto set = readGraspSet(file, kHash);
    if (!set) {
      ASSERT_THAT(set.error().detail, testing::HasSubstr(file.string())) << "seed " << seed;
      continue;
    }
    // Only what says the same in other words, and the names that the hash stands for, may differ.
    ASSERT_EQ(set->grasps.size(), 2u) << "seed " << seed << "\n" << text;
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_EQ(set->grasps[i].closed, twoGrasps().grasps[i].closed) << "seed " << seed;
      ASSERT_EQ(set->grasps[i].X_OT.translation(), twoGrasps().grasps[i].X_OT.translation())
          << "seed " << seed;
    }
  }
}

class DamagedMap : public testing::Test {
 protected:
  DamagedMap() {
    const RobotModel model = planarArm();
    const ReachabilityParams params{.voxel = 0.1, .samples = 2000, .seed = 1};
    const RobotVector q = RobotVector::Zero(2);
    hash_ = ReachabilityMap::hash(model, ArmId(0), q, params);
    const auto built = ReachabilityMap::build(model, q, params, {}, {file_}, {}, Deadline());
    if (!built) throw std::runtime_error(built.error().detail);
    good_ = contentOf(file_);
  }

  /// Opens these bytes and, if they are taken, asks the map for points in and around it.
  bool taken(const std::string& bytes) {
    folder_.write("map", bytes);
    const auto map = ReachabilityMap::open(file_, hash_);
    if (!map) {
      EXPECT_THAT(map.error().detail, testing::HasSubstr(file_.string()));
      return false;
    }
    double sum = 0;
    for (double x = -1; x <= 1; x += 0.05) {
      for (double y = -1; y <= 1; y += 0.05) sum += (**map)({x, y, 0.01});
    }
    sum += (**map)({1e300, -1e300, 0});
    EXPECT_TRUE(std::isfinite(sum));
    return true;
  }

  TemporaryFolder folder_;
  fs::path file_ = folder_ / "map";
  std::uint64_t hash_ = 0;
  std::string good_;
};

TEST_F(DamagedMap, IsRefused) {
  ASSERT_TRUE(taken(good_));
  for (int seed = 1; seed <= fuzzRuns(500); ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    const std::string bytes = damaged(good_, generator);
    ASSERT_EQ(taken(bytes), bytes == good_) << "seed " << seed;
  }
}

TEST_F(DamagedMap, WithAChecksumThatFitsIsReadWithinItsBounds) {
  int refused = 0;
  for (int seed = 1; seed <= fuzzRuns(1000); ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    std::string bytes = good_;
    // In the header and the first indices, where sizes are.
    for (std::size_t changes = 1 + generator() % 3; changes > 0; --changes) {
      const std::size_t at = 32 + generator() % 400;
      bytes[at] = static_cast<char>(generator() % 3 == 0 ? 0xFF : generator() & 0xFFu);
    }
    const std::uint64_t sum = XXH3_64bits(bytes.data() + 24, bytes.size() - 24);
    std::memcpy(bytes.data() + 16, &sum, sizeof(sum));
    refused += taken(bytes) ? 0 : 1;
  }
  EXPECT_GT(refused, fuzzRuns(1000) / 10);
}

}  // namespace
}  // namespace handover::test
