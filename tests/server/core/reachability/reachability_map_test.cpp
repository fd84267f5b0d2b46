// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/reachability_map.hpp"

#include "file_bytes.hpp"
#include "support/arm_models.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>

namespace handover::test {
namespace {

using Map = std::shared_ptr<const ReachabilityMap>;

Map buildAndOpen(const RobotModel& model, const ReachabilityParams& params,
                 const ReachabilityMap::SelfCollision& self_collision,
                 const std::filesystem::path& file) {
  const RobotVector q = RobotVector::Zero(model.dofs());
  const auto built =
      ReachabilityMap::build(model, q, params, {self_collision}, {file}, {}, Deadline());
  if (!built) throw std::runtime_error(built.error().detail);
  const auto map = ReachabilityMap::open(file, ReachabilityMap::hash(model, ArmId(0), q, params));
  if (!map) throw std::runtime_error(map.error().detail);
  return *map;
}

TEST(DirectionBin, DividesTheSphereIntoEqualAreas) {
  // Points of even area: each of 64 bins gets its share.
  std::array<int, 64> hits{};
  constexpr int kHeights = 400, kTurns = 800;
  for (int i = 0; i < kHeights; ++i) {
    for (int j = 0; j < kTurns; ++j) {
      const double z = -1 + (i + 0.5) * 2 / kHeights, a = (j + 0.5) * 2 * M_PI / kTurns;
      const double r = std::sqrt(1 - z * z);
      const int bin = directionBin({r * std::cos(a), r * std::sin(a), z});
      ASSERT_GE(bin, 0);
      ASSERT_LT(bin, 64);
      ++hits[static_cast<std::size_t>(bin)];
    }
  }
  for (const int n : hits) EXPECT_EQ(n, kHeights * kTurns / 64);
}

TEST(DirectionBin, TakesThePolesAndTheSeam) {
  EXPECT_GE(directionBin({0, 0, 1}), 56);
  EXPECT_LT(directionBin({0, 0, -1}), 8);
  EXPECT_EQ(directionBin({-1, 1e-18, 0}), 39);
  EXPECT_EQ(directionBin({-1, -1e-9, 0}), 32);
  EXPECT_GE(directionBin({0, 0, 1 + 1e-12}), 56);
}

TEST(ReachabilityMap, HoldsThePlainAverageOfItsSamples) {
  const TemporaryFolder folder;
  const RobotModel model = huboArm(1);
  const ArmKinematics arm(model, ArmId(0));
  std::vector<ArmVector> drawn;
  const ReachabilityParams params{.voxel = 0.1, .samples = 20'000, .seed = 7};
  const Map map = buildAndOpen(
      model, params,
      [&](const ArmVector& q) {
        drawn.push_back(q);
        return false;
      },
      folder / "map");
  ASSERT_EQ(drawn.size(), params.samples);

  struct Expected {
    double sum = 0, best = -1;
    std::uint32_t samples = 0;
    std::uint64_t directions = 0;
    ArmVector q_best;
  };

  std::map<std::array<int, 3>, Expected> voxels;
  for (const ArmVector& q : drawn) {
    ASSERT_TRUE(arm.withinLimits(q, 0));
    const Pose X_AT = arm.toolPose(q);
    std::array<int, 3> key{};
    for (int axis = 0; axis < 3; ++axis) {
      key[static_cast<std::size_t>(axis)] =
          static_cast<int>(std::floor(X_AT.translation()[axis] / 0.1));
    }
    Expected& voxel = voxels[key];
    const double w = arm.manipulability(q);
    voxel.sum += w;
    ++voxel.samples;
    voxel.directions |= std::uint64_t{1} << directionBin(-X_AT.linear().col(2));
    if (w > voxel.best) {
      voxel.best = w;
      voxel.q_best = q;
    }
  }
  EXPECT_EQ(map->filledVoxels(), voxels.size());
  for (const auto& [key, expected] : voxels) {
    const Eigen::Vector3d centre =
        0.1 * (Eigen::Vector3d(key[0], key[1], key[2]) + Eigen::Vector3d::Constant(0.5));
    const ReachabilityVoxel* voxel = map->find(centre);
    ASSERT_NE(voxel, nullptr);
    EXPECT_FLOAT_EQ(voxel->manipulability, static_cast<float>(expected.sum / expected.samples));
    EXPECT_EQ((*map)(centre), double{voxel->manipulability});
    EXPECT_EQ(voxel->samples, expected.samples);
    EXPECT_EQ(voxel->directions, expected.directions);
    for (int i = 0; i < 7; ++i) {
      EXPECT_EQ(voxel->q_seed[static_cast<std::size_t>(i)], static_cast<float>(expected.q_best[i]));
    }
    EXPECT_EQ(voxel->q_seed[7], 0.0f);
  }
}

TEST(ReachabilityMap, ReachesNothingOutsideItsGridOrInItsHoles) {
  const TemporaryFolder folder;
  const Map map =
      buildAndOpen(planarArm(), {.voxel = 0.05, .samples = 20'000, .seed = 1}, {}, folder / "map");
  EXPECT_NE(map->find({0.42, 0.02, 0.01}), nullptr);
  EXPECT_EQ(map->find({0.02, 0.02, 0.01}), nullptr);  // the hole in the ring
  EXPECT_EQ((*map)({0.02, 0.02, 0.01}), 0);
  EXPECT_EQ(map->find({0.42, 0.02, 0.06}), nullptr);
  EXPECT_EQ(map->find({0.42, 0.02, -0.01}), nullptr);
  const double inf = INFINITY, nan = std::nan("");
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(-5, 0, 0), Eigen::Vector3d(1e300, 0, 0),
        Eigen::Vector3d(inf, 0, 0), Eigen::Vector3d(-inf, 0, 0), Eigen::Vector3d(0.4, nan, 0)}) {
    EXPECT_EQ(map->find(p), nullptr);
    EXPECT_EQ((*map)(p), 0);
  }
}

TEST(ReachabilityMap, LeavesOutSamplesInSelfCollision) {
  const TemporaryFolder folder;
  const ReachabilityParams params{.voxel = 0.05, .samples = 20'000, .seed = 1};
  const RobotModel model = planarArm();
  const auto folded = [](const ArmVector& q) { return std::abs(q[1]) > 1; };
  const Map all = buildAndOpen(model, params, {}, folder / "all");
  const Map some = buildAndOpen(model, params, folded, folder / "some");
  EXPECT_LT(some->filledVoxels(), all->filledVoxels());
  EXPECT_NE(some->find({0.47, 0.02, 0.01}), nullptr);
  EXPECT_NE(all->find({0.27, 0.02, 0.01}), nullptr);
  EXPECT_EQ(some->find({0.27, 0.02, 0.01}), nullptr);

  const Map none = buildAndOpen(
      model, params, [](const ArmVector&) { return true; }, folder / "none");
  EXPECT_EQ(none->filledVoxels(), 0u);
  EXPECT_EQ(none->find({0.47, 0.02, 0.01}), nullptr);
}

TEST(ReachabilityMap, IsTheSameToTheByteEachTime) {
  const TemporaryFolder folder;
  ReachabilityParams params{.voxel = 0.05, .samples = 30'000, .seed = 3};
  buildAndOpen(lwa4Arm(), params, {}, folder / "a");
  buildAndOpen(lwa4Arm(), params, {}, folder / "b");
  EXPECT_EQ(readBytes(folder / "a"), readBytes(folder / "b"));
  params.seed = 4;
  buildAndOpen(lwa4Arm(), params, {}, folder / "c");
  EXPECT_NE(readBytes(folder / "a"), readBytes(folder / "c"));
}

struct Published {
  RobotModel model;
  double voxels, mean, most;
};

TEST(ReachabilityMap, AgreesWithAnIndependentComputationOfThePapersArms) {
  // Figures of another program for the same arms: 1e6 samples, 0.05 m, no collisions.
  const TemporaryFolder folder;
  for (const Published& published : {Published{lwa4Arm(), 22'900, 0.0314, 0.080},
                                     Published{huboArm(1), 15'900, 0.0218, 0.069}}) {
    const ArmKinematics arm(published.model, ArmId(0));
    double sum = 0, most = 0;
    const Map map = buildAndOpen(
        published.model, {},
        [&](const ArmVector& q) {
          const double w = arm.manipulability(q);
          sum += w;
          most = std::max(most, w);
          return false;
        },
        folder / published.model.name);
    EXPECT_NEAR(static_cast<double>(map->filledVoxels()), published.voxels,
                0.05 * published.voxels);
    EXPECT_NEAR(sum / 1e6, published.mean, 0.05 * published.mean);
    EXPECT_NEAR(most, published.most, 0.05 * published.most);
  }
}

TEST(ReachabilityMap, ReportsProgressFromNothingToAll) {
  const TemporaryFolder folder;
  std::vector<double> seen;
  const RobotModel model = planarArm();
  const auto built = ReachabilityMap::build(
      model, RobotVector::Zero(2), {.samples = 5000}, {}, {folder / "map"},
      [&](double done) { seen.push_back(done); }, Deadline());
  ASSERT_TRUE(built.has_value());
  ASSERT_GE(seen.size(), 3u);
  EXPECT_EQ(seen.front(), 0);
  EXPECT_EQ(seen.back(), 1);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
}

TEST(ReachabilityMap, StopsWhenCancelledAndLeavesNoFile) {
  const TemporaryFolder folder;
  const RobotModel model = planarArm();
  const Deadline deadline;
  const auto built = ReachabilityMap::build(
      model, RobotVector::Zero(2), {}, {}, {folder / "map"},
      [&](double done) {
        if (done > 0.1) deadline.cancel();
      },
      deadline);
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().code, ErrorCode::kCancelled);
  const auto late = ReachabilityMap::build(model, RobotVector::Zero(2), {}, {}, {folder / "map"},
                                           {}, Deadline(Deadline::Clock::now()));
  ASSERT_FALSE(late.has_value());
  EXPECT_EQ(late.error().code, ErrorCode::kDeadline);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ReachabilityMap, RefusesParametersWithoutSense) {
  const TemporaryFolder folder;
  const RobotModel model = planarArm();
  for (const double voxel : {0.0, -0.05, 1e-9, std::nan(""), double(INFINITY)}) {
    const auto built = ReachabilityMap::build(model, RobotVector::Zero(2), {.voxel = voxel}, {},
                                              {folder / "map"}, {}, Deadline());
    ASSERT_FALSE(built.has_value()) << voxel;
    EXPECT_EQ(built.error().code, ErrorCode::kInvalidInput);
  }
  const auto built = ReachabilityMap::build(model, RobotVector::Zero(2), {.samples = 0}, {},
                                            {folder / "map"}, {}, Deadline());
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().code, ErrorCode::kInvalidInput);
}

}  // namespace
}  // namespace handover::test
