// SPDX-License-Identifier: Apache-2.0
// One stage of every kind, filled with values that differ from their defaults, and a whole small
// answer.
#pragma once

#include <handover/common/plan_event.hpp>

#include <string>
#include <vector>

namespace handover::test {

inline PoseValue samplePose(double x) { return {{x, -0.5, 1e-3}, {0.6, 0.0, -0.8, 0.0}}; }

inline SceneSnapshot sampleScene() {
  SceneSnapshot scene{.cell = "butler", .task = "serve", .seed = 18446744073709551615ull};
  scene.scene_hash = "0123abcd";
  scene.object = "cup";
  scene.giver = "crichton";
  scene.receiver = "hubo";
  scene.X_WO_start = samplePose(0.1);
  scene.X_WO_goal = samplePose(0.2);
  RobotSnapshot robot{.name = "hubo", .urdf = "robots/hubo/hubo.urdf"};
  robot.urdf_sha256 = std::string(64, 'a');
  robot.srdf = "robots/hubo/hubo.srdf";
  robot.X_WB = samplePose(1.18);
  robot.q_start = {{"RSP", 0.1}, {"TSY", -1.0 / 3.0}};
  robot.limits = {{"RSP", {-1, 1, 1, 0.8}}, {"TSY", {-2, 2, 0.5, 0.25}}};
  robot.resting = {{"leftFoot", "floor"}};
  scene.robots = {robot};
  const CompoundGeometry compound{
      {{samplePose(0.3), CylinderGeometry{0.04, 0.1}},
       {samplePose(0.4), MeshGeometry{"robots/objects/a.obj", {1, 2, 3}}}}};
  ObjectSnapshot tray{
      .name = "tray", .geometry = BoxGeometry{{0.3, 0.2, 0.01}}, .X_WO = samplePose(1)};
  tray.attached_to =
      AttachmentSnapshot{"hubo", "rightPalm", samplePose(0.05), {"rightPalm", "Body_RF11"}};
  ObjectSnapshot cup{.name = "cup", .geometry = compound, .X_WO = samplePose(0.1)};
  cup.resting = {"cart"};
  scene.objects = {tray, cup, {"ball", SphereGeometry{0.05}, samplePose(2), {}, {}}};
  return scene;
}

inline Solution sampleSolution(std::uint32_t index = 0) {
  Solution solution{.index = index, .giver_arm = "right", .receiver_arm = "left"};
  solution.giver_tool_link = "right_grasp_link";
  solution.receiver_tool_link = "left_tool";
  solution.giver_grasp = 17;
  solution.receiver_grasp = 203;
  solution.X_WO_handover = samplePose(0.5);
  solution.X_OT_giver = samplePose(0.01);
  solution.X_OT_receiver = samplePose(0.02);
  solution.dexterity = {0.011, 0.012, 0.1, 0.2};
  return solution;
}

inline StageTrajectory sampleTrajectory(std::uint32_t solution, int index) {
  StageTrajectory stage{.solution = solution, .index = static_cast<std::uint32_t>(index)};
  stage.kind = static_cast<StageKind>(index + 1);
  stage.robot = index < 5 ? "crichton" : "hubo";
  stage.joints = {"RSP", "RSR"};
  stage.start = 0.5 * index;
  stage.t = {0, 0.25, 0.5};
  stage.q = {{0, 0.1}, {0.05, 0.2}, {0.1, 1.0 / 3.0}};
  stage.qd = {{0, 0}, {0.2, 0.4}, {0, 0}};
  stage.holding = {{"tray", "hubo", "rightPalm", samplePose(0.05)}};
  stage.may_touch = {{"hubo/leftPalm", "cup"}};
  return stage;
}

inline Failed sampleFailure() {
  Failed failed{.reason = FailureReason::kNoGraspAtGoal};
  failed.explanation = {
      .filter = "receiver_grasps",
      .text = "no grasp of cup by hubo is free at the goal",
      .causes = {{"collision", {"hubo/Body_LWR", "tray"}, 300}, {"no_ik", {}, 68}},
      .nearest_fix = {{"robots.hubo.base.xyz", "[1.1, -0.3, 0.98]"}},
      .fix_text = "tried 12 of 200 moves of hubo"};
  return failed;
}

/// Every kind of payload and of outcome.
inline std::vector<PlanEventPayload> samplePayloads() {
  return {
      Accepted{3, 42},
      sampleScene(),
      ArmSelected{
          "right", "left", {{"hubo", "left", 0.0123, ""}, {"hubo", "right", 0, "holds the tray"}}},
      GraspsPruned{"hubo", "left", 368, 40, {{"no_ik", {}, 300}, {"collision", {"a", "b"}, 28}}},
      HandoverCandidates{"right",
                         "left",
                         12,
                         40,
                         17,
                         300,
                         {{"limits", {}, 4}},
                         {{{0.625, -0.125, 1.025}, 0.5}, {{0.625, -0.075, 1.025}, 0.25}}},
      sampleSolution(2),
      sampleTrajectory(2, 6),
      Outcome{Done{2, false}},
      Outcome{sampleFailure()},
      Outcome{Cancelled{}},
      Outcome{Rejected{"scene_changed", {{"expected_revision", "is 1, the scene has 2"}}}}};
}

/// A whole answer: two solutions, the second one final.
inline std::vector<PlanEvent> sampleAnswer(const RequestId& id, double pace = 0.001) {
  std::vector<PlanEventPayload> payloads = {Accepted{0, 7}, sampleScene(), samplePayloads()[2],
                                        samplePayloads()[3], samplePayloads()[4]};
  for (std::uint32_t solution = 0; solution < 2; ++solution) {
    payloads.emplace_back(sampleSolution(solution));
    for (int i = 0; i < kStageCount; ++i) payloads.emplace_back(sampleTrajectory(solution, i));
  }
  payloads.emplace_back(Outcome{Done{1, true}});
  std::vector<PlanEvent> stages;
  for (std::uint32_t i = 0; i < payloads.size(); ++i) {
    stages.push_back({id, i, pace * (i + 1), payloads[i]});
  }
  return stages;
}

}  // namespace handover::test
