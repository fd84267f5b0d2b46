// SPDX-License-Identifier: Apache-2.0
// What a failure says of where its arms reach, against forward kinematics and by its height.
#include "core/planning/workspaces.hpp"

#include "butler_service.hpp"
#include "core/planning/manipulator.hpp"
#include "support/random_configurations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace handover::test {
namespace {

/// Six metres away, so that nothing is in reach of both.
const std::vector<Override> kFarHubo{{"robots.hubo.base.xyz", "[6, -0.3, 0.98]"}};

TransportProblem problemOf(const std::vector<Override>& overrides) {
  return std::get<TransportProblem>(
      butlerService().problemOf(butlerRequest(overrides), Deadline()));
}

Failed failureOf(FailureReason reason) {
  Failed failed;
  failed.reason = reason;
  return failed;
}

/// The entry of the cell that a point of the plane is in; 0 outside.
double entryAt(const ReachSlice& slice, double x, double y) {
  if (slice.columns == 0) return 0;
  const auto place = [](double at, double first) {
    return static_cast<long>(std::lround((at - first) / kLatticeEdge));
  };
  const long column = place(x, slice.first[0]), row = place(y, slice.first[1]);
  const auto columns = static_cast<long>(slice.columns);
  const long rows = static_cast<long>(slice.scores.size()) / columns;
  if (column < 0 || column >= columns || row < 0 || row >= rows) return 0;
  return slice.scores[static_cast<std::size_t>(row * columns + column)];
}

double entryNear(const ReachSlice& slice, double x, double y) {
  double most = 0;
  for (const double i : {-1, 0, 1}) {
    for (const double j : {-1, 0, 1}) {
      most = std::max(most, entryAt(slice, x + i * kLatticeEdge, y + j * kLatticeEdge));
    }
  }
  return most;
}

TEST(Workspaces, FollowTheReasonOnceItIsKnown) {
  PlanRequest request = butlerRequest(kFarHubo);
  request.wants_fix = false;
  const Answer answer = ask(request);
  ASSERT_GE(answer.events.size(), 2u);
  EXPECT_TRUE(std::holds_alternative<Failure>(answer.events[answer.events.size() - 2]));
  const auto all = answer.all<Workspaces>();
  ASSERT_EQ(all.size(), 1u);
  std::vector<ArmName> arms;
  for (const ReachSlice& slice : all[0].slices) arms.push_back(slice.arm);
  // Hubo's right hand has the tray.
  EXPECT_THAT(arms, testing::ElementsAre(ArmName{"crichton", "left"}, ArmName{"crichton", "right"},
                                         ArmName{"hubo", "left"}));
  EXPECT_TRUE(ask(butlerRequest()).all<Workspaces>().empty());  // of a plan
}

TEST(Workspaces, AreWhereForwardKinematicsComes) {
  const TransportProblem problem = problemOf({});
  const Workspaces all = workspacesOf(problem, failureOf(FailureReason::kNoCommonWorkspace));
  ASSERT_EQ(all.slices.size(), 3u);
  for (const ReachSlice& slice : all.slices) {
    const RobotId robot = problem.scene->findRobot(slice.arm.robot);
    const RobotModel& model = *problem.scene->robots[robot].model;
    const Manipulator arm = makeManipulator(problem, robot, model.findArm(slice.arm.arm));
    EXPECT_EQ(slice.tool_link, arm.toolLink());
    RandomConfigurations configurations(*arm.kinematics, 23);
    int in_plane = 0, shown = 0;
    for (int i = 0; i < 200'000; ++i) {
      const Eigen::Vector3d p = arm.toolPose(configurations.next()).translation();
      if (std::abs(p.z() - all.z) > 0.005) continue;
      ++in_plane;
      shown += entryNear(slice, p.x(), p.y()) > 0;
    }
    EXPECT_GT(in_plane, 300);
    // Maps leave out where an arm touches itself or the torso.
    EXPECT_GT(shown, 0.95 * in_plane) << slice.arm.robot << "/" << slice.arm.arm;
    const double reach = arm.kinematics->reach() + 2 * kLatticeEdge;
    const Eigen::Vector3d base = arm.map.X_WA.translation();
    for (std::size_t cell = 0; cell < slice.scores.size(); ++cell) {
      const double x = slice.first[0] + kLatticeEdge * static_cast<double>(cell % slice.columns);
      const double y = slice.first[1] + kLatticeEdge * static_cast<double>(cell / slice.columns);
      if (slice.scores[cell] == 0) continue;
      EXPECT_LT(std::hypot(x - base.x(), y - base.y()), reach);
    }
  }
}

TEST(Workspaces, OfArmsFarApartShareNoCell) {
  const Workspaces all =
      workspacesOf(problemOf(kFarHubo), failureOf(FailureReason::kNoCommonWorkspace));
  const ReachSlice &giver = all.slices.at(1), &receiver = all.slices.at(2);
  for (std::size_t cell = 0; cell < giver.scores.size(); ++cell) {
    const double x = giver.first[0] + kLatticeEdge * static_cast<double>(cell % giver.columns);
    const double y = giver.first[1] + kLatticeEdge * static_cast<double>(cell / giver.columns);
    if (giver.scores[cell] == 0) continue;
    EXPECT_EQ(entryAt(receiver, x, y), 0);
  }
}

TEST(Workspaces, AreCutAtTheHeightThatTheFailureIsAbout) {
  const TransportProblem problem = problemOf({});
  const auto height = [&](const Failed& failed) { return workspacesOf(problem, failed).z; };
  EXPECT_EQ(height(failureOf(FailureReason::kStartUnreachable)),
            problem.task.X_WO_start.translation().z());
  EXPECT_EQ(height(failureOf(FailureReason::kGoalInCollision)),
            problem.task.X_WO_goal.translation().z());
  const auto shoulder = [&](const char* robot, const char* arm) {
    const RobotId index = problem.scene->findRobot(robot);
    const RobotModel& model = *problem.scene->robots[index].model;
    return makeManipulator(problem, index, model.findArm(arm)).map.p_WShoulder.z();
  };
  EXPECT_NEAR(height(failureOf(FailureReason::kNoCommonWorkspace)),
              (shoulder("crichton", "right") + shoulder("hubo", "left")) / 2, 1e-9);
  Failed farthest = failureOf(FailureReason::kNoPath);
  farthest.explanation.farthest = Farthest{{{0.5, 0, 1.25}, {1, 0, 0, 0}}, {}, {}};
  EXPECT_EQ(height(farthest), 1.25);
}

}  // namespace
}  // namespace handover::test
