// SPDX-License-Identifier: Apache-2.0
// One event of every kind, filled with values that differ from their defaults, and whole small
// answers: of one, two or three holders.
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
  RobotSnapshot robot{.name = "hubo", .urdf = "robots/hubo/hubo.urdf"};
  robot.srdf = "robots/hubo/hubo.srdf";
  robot.yaml = "robots/hubo/hubo.yaml";
  robot.urdf_sha256 = std::string(64, 'a');
  robot.yaml_sha256 = std::string(64, 'b');
  robot.X_WB = samplePose(1.18);
  robot.q_start = {{"RSP", 0.1}, {"TSY", -1.0 / 3.0}};
  robot.limits = {{"RSP", {-1, 1, 1, 0.8, 8}}, {"TSY", {{}, {}, 0.5, 0.25, 2.5}}};
  robot.resting = {{"leftFoot", "floor"}};
  RobotSnapshot other = robot;
  other.name = "crichton";
  other.resting.clear();
  scene.robots = {robot, other};
  const CompoundGeometry compound{
      {{samplePose(0.3), CylinderGeometry{0.04, 0.1}},
       {samplePose(0.4), MeshGeometry{"robots/objects/a.obj", {1, 2, 3}}}}};
  ObjectSnapshot tray{
      .name = "tray", .geometry = BoxGeometry{{0.3, 0.2, 0.01}}, .X_WO = samplePose(1)};
  tray.attached_to =
      AttachmentSnapshot{"hubo", "rightPalm", samplePose(0.05), {"rightPalm", "Body_RF11"}};
  ObjectSnapshot cup{.name = "cup", .geometry = compound, .X_WO = samplePose(0.1)};
  ObjectSnapshot ball{"ball", SphereGeometry{0.05}, samplePose(2), {}, {"tray"}};
  scene.objects = {tray, cup, ball};
  scene.start = {samplePose(0.1), {}, {false, {"cart"}}};
  scene.goal = {samplePose(0.2), TransportEnd::kRelease, {false, {"tray"}}};
  scene.upright = UprightSnapshot{{0, 0, 1}, 10.5};
  return scene;
}

/// Who moves in a sample plan of so many holders.
inline ArmName sampleArm(std::uint32_t holder) {
  return {holder % 2 == 0 ? "crichton" : "hubo", holder < 2 ? "right" : "left"};
}

inline Holder sampleHolder(std::uint32_t place) {
  Holder holder{.arm = sampleArm(place), .tool_link = "grasp_link_" + std::to_string(place)};
  holder.gripper = FingerGripper{"palm", {"finger_1", "finger_2"}};
  if (place == 2) holder.gripper = SuctionGripper{"cup", {0, 0, -1}, 0.02};
  holder.X_OT = samplePose(0.01 * (place + 1));
  holder.grasp = 17 + place;
  holder.dexterity = {0.1 + place, 0.2 + place};
  return holder;
}

inline Quality sampleQuality() {
  Quality quality{.duration_s = 12.5, .bound_s = 10, .object_s = 7};
  quality.idle_s = {{"crichton", 0.5}, {"hubo", 0}};
  quality.clearance = {{"furniture", 0.012, 4, {"crichton/L7", "table"}}, {"robots", 0.05, 9, {}}};
  quality.tilt_deg = 3.5;
  quality.object_turn_deg = {120, 90};
  quality.limit_margin = 0.125;
  quality.grip = {{0, 0.25, 0.75}, {1, 0.5, 1}};
  quality.jerk_share = 0.875;
  quality.cost = 14.5;
  quality.terms = {{"duration", 12.5}, {"clearance", 2}};
  return quality;
}

/// Holder and action of every stage of a plan, in the order of `index` (design §5, Stages): 16 for
/// two holders. O is at rest at the start and put down.
inline std::vector<StageRef> sampleStages(std::uint32_t holders) {
  using enum StageAction;
  std::vector<StageRef> stages;
  const auto add = [&stages](std::uint32_t holder, std::initializer_list<StageAction> actions) {
    for (const StageAction action : actions) stages.push_back({holder, action});
  };
  add(0, {kReach, kApproach, kGrasp, kLift, kCarry});
  for (std::uint32_t k = 1; k < holders; ++k) {
    add(k, {kReach, kApproach, kGrasp});
    add(k - 1, {kRelease, kRetreat, kHome});
    add(k, {kCarry});
  }
  add(holders - 1, {kPlace, kRelease, kRetreat, kHome});
  return stages;
}

inline Solution sampleSolution(std::uint32_t index = 0, std::uint32_t holders = 2) {
  Solution solution{.index = index};
  for (std::uint32_t k = 0; k < holders; ++k) solution.holders.push_back(sampleHolder(k));
  for (std::uint32_t k = 1; k < holders; ++k) {
    solution.X_WO_handovers.push_back(samplePose(0.5 * k));
  }
  solution.stage_count = static_cast<std::uint32_t>(sampleStages(holders).size());
  solution.slack_s = 0.25;
  solution.cost = 14.5 - index;
  solution.quality = sampleQuality();
  solution.quality->cost = solution.cost;
  return solution;
}

inline StageTrajectory sampleTrajectory(std::uint32_t solution, std::uint32_t index,
                                        std::uint32_t holders = 2) {
  const StageRef ref = sampleStages(holders).at(index);
  StageTrajectory stage{.solution = solution, .index = index, .holder = ref.holder};
  stage.action = ref.action;
  stage.robot = sampleArm(ref.holder).robot;
  stage.start = 0.5 * index;
  stage.t = {0, 0.25, 0.5};
  const bool suction =
      ref.holder == 2 && (ref.action == StageAction::kGrasp || ref.action == StageAction::kRelease);
  if (suction) {
    stage.q = stage.qd = stage.qdd = {{}, {}, {}};
  } else {
    stage.joints = {"RSP", "TSY"};
    stage.q = {{0, 0.1}, {0.05, 0.2}, {0.1, 1.0 / 3.0}};
    stage.qd = {{0, 0}, {0.2, 0.4}, {0, 0}};
    stage.qdd = {{0, 0}, {0.5, -0.25}, {0, 0}};
  }
  stage.holding = {{"tray", "hubo", "rightPalm", samplePose(0.05)}};
  stage.may_touch = {{"hubo/leftPalm", "cup"}};
  if (index > 0) stage.after = {{index - 1, 0.5}};
  return stage;
}

inline Explanation sampleExplanation() {
  Explanation why{.filter = "grasps_at_goal",
                  .text = "No grasp of cup by hubo/left is free at the goal.",
                  .exhaustive = true};
  why.causes = {{Cause::kCollision, {"hubo/Body_LWR", "tray"}, {}, 300},
                {Cause::kNoIk, {}, {}, 68},
                {Cause::kHoldsObject, {"hubo/right", ""}, {}, 1},
                {Cause::kTiming, {"cup", "table"}, {{1, StageAction::kPlace}}, 2}};
  why.nearest_fix = {{"robots.hubo.base.xyz", "[1.1, -0.3, 0.98]"}};
  why.fix_text = "12 of 200 moves of hubo were tried.";
  why.farthest =
      Farthest{samplePose(0.2), {{sampleArm(1), samplePose(0.3)}}, {1, StageAction::kPlace}};
  return why;
}

inline Failed sampleFailure() { return {FailureReason::kNoGraspAtGoal, sampleExplanation()}; }

inline Accepted sampleAccepted() {
  return {.daemon_id = {1, 2, 3},
          .epoch = 3,
          .program_version = "0.2.0",
          .scene_revision = 7,
          .scene_hash = "0123abcd",
          .queue_place = 2};
}

inline ArmSelected sampleArms() {
  return {{sampleArm(0), sampleArm(1)},
          {{sampleArm(0), 0, 0.0123, Cause::kUnspecified, ""},
           {sampleArm(1), 1, 0, Cause::kHoldsObject, "tray"}}};
}

inline Workspaces sampleWorkspaces() {
  return {1.025,
          {{sampleArm(0), "grasp_link_0", {0.025, -0.075}, 3, {0, 0.25, 0.5, 0.125, 0, 0}},
           {sampleArm(1), "grasp_link_1", {0, 0}, 0, {}}}};
}

/// Every kind of payload and of outcome.
inline std::vector<PlanEventPayload> samplePayloads() {
  return {sampleAccepted(),
          sampleScene(),
          sampleArms(),
          GraspsPruned{
              .arm = sampleArm(1),
              .holder = 1,
              .place = PruningPlace::kGoal,
              .tested = 368,
              .kept = 40,
              .causes = {{Cause::kNoIk, {}, {}, 300}, {Cause::kCollision, {"a", "b"}, {}, 28}}},
          HandoverCandidates{
              .handover = 0,
              .giver = sampleArm(0),
              .receiver = sampleArm(1),
              .lattice_points = 12,
              .poses_tried = 40,
              .poses = 17,
              .receiver_grasps = 34,
              .tuples = 306,
              .causes = {{Cause::kLimits, {}, {}, 4}},
              .lattice = {{{0.625, -0.125, 1.025}, 0.5}, {{0.625, -0.075, 1.025}, 0.25}}},
          sampleSolution(2),
          sampleTrajectory(2, 6),
          Note{"one_arm_suffices", "crichton/right could do it alone."},
          Failure{FailureReason::kNoGraspAtGoal, sampleExplanation()},
          Fix{{{"robots.hubo.base.xyz", "[1.1, -0.3, 0.98]"}}, "12 of 200 moves were tried."},
          Outcome{Done{2, false}},
          Outcome{sampleFailure()},
          Outcome{Cancelled{CancelCause::kClientLost}},
          Outcome{Rejected{RejectionReason::kSceneChanged,
                           {{"expected_revision", "is 1, the scene has 2"}}}},
          sampleWorkspaces()};
}

inline constexpr AnswerId kSampleAnswer{0xa5};

inline std::vector<PlanEvent> sampleEvents(const RequestId& id,
                                           const std::vector<PlanEventPayload>& payloads,
                                           double pace = 0.001) {
  std::vector<PlanEvent> events;
  for (std::uint32_t i = 0; i < payloads.size(); ++i) {
    events.push_back({id, kSampleAnswer, i, pace * (i + 1), payloads[i]});
  }
  return events;
}

/// A whole answer: two solutions, the second one final.
inline std::vector<PlanEvent> sampleAnswer(const RequestId& id, double pace = 0.001,
                                           std::uint32_t holders = 2) {
  Accepted accepted = sampleAccepted();
  accepted.queue_place = 0;
  const std::vector<PlanEventPayload> samples = samplePayloads();
  std::vector<PlanEventPayload> payloads = {accepted, sampleScene(), samples[2], samples[3],
                                            samples[4]};
  const auto stages = static_cast<std::uint32_t>(sampleStages(holders).size());
  for (std::uint32_t solution = 0; solution < 2; ++solution) {
    payloads.emplace_back(sampleSolution(solution, holders));
    for (std::uint32_t i = 0; i < stages; ++i) {
      payloads.emplace_back(sampleTrajectory(solution, i, holders));
    }
  }
  const Outcome done = Done{1, true};  // a temporary of it makes GCC 12 see what nobody has set
  payloads.emplace_back(done);
  return sampleEvents(id, payloads, pace);
}

/// An answer that is a failure, known before the search for a fix.
inline std::vector<PlanEvent> sampleFailedAnswer(const RequestId& id) {
  const std::vector<PlanEventPayload> samples = samplePayloads();
  return sampleEvents(id, {sampleAccepted(), sampleScene(), samples[2], samples[3], samples[8],
                           sampleWorkspaces(), samples[9], Outcome{sampleFailure()}});
}

}  // namespace handover::test
