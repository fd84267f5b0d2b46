// SPDX-License-Identifier: Apache-2.0
// Files damaged at random (seeded): read or refused with a FileError, never anything else.
#include "settings/check.hpp"
#include "tiny_root.hpp"

#include <gtest/gtest.h>

#include <random>

namespace handover {
namespace {

using handover::testing::TinyRoot;

constexpr const char* kTetrahedron =
    "o t\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// Some bytes changed, cut out, doubled, or swapped for words that readers stumble over.
std::string damaged(std::string text, std::mt19937_64& generator) {
  static const char* const kWords[] = {"nan",         "-1", "1e999", "[",    "{",  "*a",
                                       "&a",          "<",  "\"",    "0",    "\n", ": ",
                                       "99999999999", "/",  "..",    "\xFF", "-",  "<link/>"};
  const auto below = [&generator](std::size_t n) {
    return generator() % std::max<std::size_t>(n, 1);
  };
  for (std::size_t changes = 1 + below(4); changes > 0 && !text.empty(); --changes) {
    const std::size_t at = below(text.size()), length = 1 + below(12);
    switch (below(4)) {
      case 0:
        text[at] = static_cast<char>(generator() & 0xFFu);
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(below(text.size()), length));
        break;
      default:
        text.replace(at, length, kWords[below(std::size(kWords))]);
        break;
    }
  }
  return text;
}

/// Damages one file of a good root again and again and checks another.
void damageAndCheck(const std::string& damaged_file, const std::string& good,
                    const std::string& checked_file, int times) {
  const TinyRoot root;
  root.write(damaged_file, good);
  ASSERT_TRUE(checkFiles({root.path() / checked_file}, root.path()).empty());
  int refused = 0;
  for (int seed = 1; seed <= times; ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    const std::string text = damaged(good, generator);
    root.write(damaged_file, text);
    ASSERT_NO_THROW(refused += !checkFiles({root.path() / checked_file}, root.path()).empty())
        << "seed " << seed << "\n"
        << text;
  }
  EXPECT_GT(refused, times / 10);
}

TEST(DamagedFiles, Urdf) {
  damageAndCheck("robots/tiny/tiny.urdf", handover::testing::kTinyUrdf, "robots/tiny/tiny.yaml",
                 500);
}

TEST(DamagedFiles, Srdf) {
  damageAndCheck("robots/tiny/tiny.srdf", handover::testing::kTinySrdf, "robots/tiny/tiny.yaml",
                 500);
}

TEST(DamagedFiles, RobotSettings) {
  damageAndCheck("robots/tiny/tiny.yaml", handover::testing::kTinyYaml, "robots/tiny/tiny.yaml",
                 500);
}

TEST(DamagedFiles, Cell) {
  damageAndCheck("config/cells/test.yaml", handover::testing::kTinyCell, "config/cells/test.yaml",
                 500);
}

TEST(DamagedFiles, DaemonSettings) {
  damageAndCheck("handoverd.yaml", "version: 1\ncells: [a, b]\ndomain: 3\nthreads: 2\n",
                 "handoverd.yaml", 300);
}

TEST(DamagedFiles, Mesh) { damageAndCheck("t.obj", kTetrahedron, "t.obj", 300); }

TEST(DamagedFiles, OverrideValuesAndPaths) {
  const TinyRoot root;
  const Cell cell = root.load();
  const std::vector<Override> good = {{"robots.right.base.xyz", "[2, 0.1, 0]"},
                                      {"objects.cup.geometry", "{type: box, size: [1, 1, 1]}"},
                                      {"robots.left.arms.arm.tool.xyz", "[0.45, 0, 0.5]"},
                                      {"tasks.fetch.goal_rest", "[table, floor]"}};
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    std::mt19937_64 generator(seed);
    Override change = good[generator() % good.size()];
    if (generator() % 3 == 0) change.path = damaged(change.path, generator);
    if (generator() % 3 != 0) change.value = damaged(change.value, generator);
    ASSERT_NO_THROW((void)cell.instantiate({change}, 1)) << change.path << " = " << change.value;
  }
}

}  // namespace
}  // namespace handover
