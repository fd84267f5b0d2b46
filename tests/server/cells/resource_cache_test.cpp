// SPDX-License-Identifier: Apache-2.0
#include "cells/resource_cache.hpp"

#include "support/arm_models.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace handover::test {
namespace {

SceneRobot planarRobot() {
  SceneRobot robot;
  robot.name = "planar";
  robot.model = std::make_shared<const RobotModel>(planarArm());
  robot.q_start = RobotVector::Zero(2);
  return robot;
}

std::shared_ptr<const ReachabilityMap> mapFrom(ResourceCache& cache, const SceneRobot& robot) {
  return cache.map(robot, ArmId(0), Deadline(), Missing::kMake);
}

TEST(ResourceCache, ProductsThatCannotBeWrittenAreUsedFromMemory) {
  const TemporaryFolder folder;
  const auto file = folder.write("file", "");
  const SceneRobot robot = planarRobot();
  ResourceCache cache(file / "below_a_file", {}, false);
  const auto map = mapFrom(cache, robot);
  ASSERT_NE(map, nullptr);
  EXPECT_GT(map->filledVoxels(), 0u);
  EXPECT_EQ(cache.map(robot, ArmId(0), Deadline(), Missing::kThrow), map);
}

TEST(ResourceCache, ReadsWhatAnotherWrote) {
  const TemporaryFolder folder;
  const SceneRobot robot = planarRobot();
  const CacheFolder kept(folder.path());
  ResourceCache first(kept, {}, false);
  const auto map = mapFrom(first, robot);
  const std::uint64_t written = kept.writtenBytes();
  EXPECT_GT(written, 0u);
  ResourceCache second(kept, {}, false);
  EXPECT_EQ(mapFrom(second, robot)->filledVoxels(), map->filledVoxels());
  EXPECT_EQ(kept.writtenBytes(), written);
}

TEST(ResourceCache, KinematicsAreThoseOfTheModelThatIsThere) {
  ResourceCache cache(std::filesystem::path(), {}, false);
  for (int i = 0; i < 20; ++i) {  // at the same place in memory, as it may come
    const auto model = std::make_shared<const RobotModel>(i % 2 == 0 ? planarArm() : sixAxisArm());
    const auto kinematics = cache.kinematics(model, ArmId(0));
    EXPECT_EQ(kinematics->reach(), ArmKinematics(*model, ArmId(0)).reach());
    EXPECT_EQ(cache.kinematics(model, ArmId(0)), kinematics);
  }
}

}  // namespace
}  // namespace handover::test
