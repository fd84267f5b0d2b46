// SPDX-License-Identifier: Apache-2.0
#include "any_events.hpp"

#include <rapidcheck.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace handover::test {
namespace {

template <typename Draw>
auto several(int least, int most, Draw draw) {
  std::vector<decltype(draw())> all;
  const int count = *rc::gen::inRange(least, most + 1);
  for (int i = 0; i < count; ++i) all.push_back(draw());
  return all;
}

bool anyBool() { return *rc::gen::arbitrary<bool>(); }

std::uint32_t anyCount() { return *rc::gen::arbitrary<std::uint32_t>(); }

std::uint64_t anyWhole() {
  // Not arbitrary<>(): it stays small.
  return (std::uint64_t{anyCount()} << 32) | *rc::gen::inRange<std::uint32_t>(0, 0xffffffff);
}

/// Finite, of any magnitude below 1e6, so that the plan file's readers take it.
double anyNumber() {
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      return *rc::gen::element(0.0, -0.0, 1.0, 1.0 / 3.0, 0.1 + 0.2, 5e-324, -1e6, 1e6,
                               std::numeric_limits<double>::min(), 1.0 - 0x1p-53);
    case 1:
      return *rc::gen::inRange(-1000, 1000) * 0.1;
    case 2:
      return std::bit_cast<double>(anyWhole() & 0xbfffffffffffffffull);  // below 2
    default:
      return std::ldexp(*rc::gen::inRange<std::int64_t>(-(1ll << 53), 1ll << 53), -51);
  }
}

double anyPositive() { return std::max(std::abs(anyNumber()), 1e-9); }

std::string anyName() {
  std::string name;
  for (const char* piece : several(1, 6, [] {
         return *rc::gen::element<const char*>("a", "Z", "7", "_", "-", ".", " ", "\"", "\\", "\n",
                                               "\t", "\x01", "\x7f", "\u00e9", "\u65e5",
                                               "\U0001f375", "[", "{", ":", "null");
       })) {
    name += piece;
  }
  return name;
}

/// Perhaps empty.
std::string anyText() { return anyBool() ? anyName() : ""; }

std::string hexDigits(int digits) {
  std::string text;
  for (int i = 0; i < digits; ++i) text += *rc::gen::elementOf(std::string("0123456789abcdef"));
  return text;
}

std::array<double, 3> anyVector() { return {anyNumber(), anyNumber(), anyNumber()}; }

PoseValue anyPose() {
  PoseValue X{anyVector(), {}};
  double square = 0;
  for (double& c : X.quat_wxyz) {
    c = *rc::gen::inRange(-1000, 1001) / 1000.0;
    square += c * c;
  }
  if (square == 0) return {X.xyz, {1, 0, 0, 0}};
  for (double& c : X.quat_wxyz) c /= std::sqrt(square);
  return X;
}

RequestId anyId() {
  RequestId id;
  for (auto& byte : id.bytes) byte = *rc::gen::arbitrary<std::uint8_t>();
  id.bytes[0] |= 1;  // an id of zeros is none
  return id;
}

NamePair anyPair() { return {anyName(), anyName()}; }

Override anyOverride() { return {anyName(), anyText()}; }

Geometry anyPrimitive() {
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      return BoxGeometry{{anyPositive(), anyPositive(), anyPositive()}};
    case 1:
      return SphereGeometry{anyPositive()};
    case 2:
      return CylinderGeometry{anyPositive(), anyPositive()};
    default:
      return MeshGeometry{"robots/r" + anyName(), {anyPositive(), -anyPositive(), anyPositive()}};
  }
}

Geometry anyGeometry() {
  if (anyBool()) return anyPrimitive();
  return CompoundGeometry{several(1, 3, [] { return GeometryPart{anyPose(), anyPrimitive()}; })};
}

std::string distinct(const std::string& what, int number) {
  return what + std::to_string(number) + anyText();
}

RobotSnapshot anyRobot(int number, const std::vector<std::string>& objects) {
  RobotSnapshot robot;
  robot.name = distinct("robot", number);
  robot.urdf = "robots/r" + anyName();
  robot.urdf_sha256 = hexDigits(64);
  robot.srdf = "robots/r" + anyName();
  robot.X_WB = anyPose();
  const int joints = *rc::gen::inRange(1, 4);
  for (int i = 0; i < joints; ++i) {
    const std::string joint = distinct("joint", i);
    const double a = anyNumber(), b = anyNumber();
    robot.q_start.emplace_back(joint, anyNumber());
    robot.limits.emplace_back(
        joint, JointLimits{std::min(a, b), std::max(a, b), anyPositive(), anyPositive()});
  }
  robot.resting = several(0, 2, [&] { return NamePair{anyName(), *rc::gen::elementOf(objects)}; });
  return robot;
}

SceneSnapshot anyScene() {
  SceneSnapshot scene;
  scene.cell = anyName();
  scene.task = anyText();
  scene.seed = anyWhole();
  scene.scene_hash = hexDigits(16);
  scene.X_WO_start = anyPose();
  scene.X_WO_goal = anyPose();
  std::vector<std::string> objects, robots;
  const int object_count = *rc::gen::inRange(1, 4), robot_count = *rc::gen::inRange(2, 4);
  for (int i = 0; i < object_count; ++i) objects.push_back(distinct("object", i));
  for (int i = 0; i < robot_count; ++i) {
    scene.robots.push_back(anyRobot(i, objects));
    robots.push_back(scene.robots.back().name);
  }
  for (const std::string& name : objects) {
    ObjectSnapshot object{name, anyGeometry(), anyPose(), {}, {}};
    if (anyBool()) {
      object.attached_to = AttachmentSnapshot{*rc::gen::elementOf(robots), anyName(), anyPose(),
                                              several(0, 2, anyName)};
    }
    object.resting = several(0, 2, [&] { return *rc::gen::elementOf(objects); });
    scene.objects.push_back(std::move(object));
  }
  scene.object = *rc::gen::elementOf(objects);
  scene.giver = robots[0];
  scene.receiver = robots[1];
  return scene;
}

RejectCount anyReject() { return {anyName(), anyBool() ? anyPair() : NamePair{}, anyCount()}; }

ArmSelected anyArms() {
  return {anyName(), anyName(), several(0, 3, [] {
            return ArmScore{anyName(), anyName(), anyNumber(), anyText()};
          })};
}

GraspsPruned anyPruned() {
  return {anyName(), anyName(), anyCount(), anyCount(), several(0, 3, anyReject)};
}

HandoverCandidates anyCandidates() {
  return {anyName(),
          anyName(),
          anyCount(),
          anyCount(),
          anyCount(),
          anyCount(),
          several(0, 3, anyReject),
          several(0, 3, [] {
            return LatticeCell{{anyNumber(), anyNumber(), anyNumber()}, anyNumber()};
          })};
}

Solution anySolution(std::uint32_t index) {
  Solution solution{.index = index, .giver_arm = anyName(), .receiver_arm = anyName()};
  solution.giver_tool_link = anyName();
  solution.receiver_tool_link = anyName();
  solution.giver_grasp = anyCount();
  solution.receiver_grasp = anyCount();
  solution.X_WO_handover = anyPose();
  solution.X_OT_giver = anyPose();
  solution.X_OT_receiver = anyPose();
  solution.dexterity = {anyNumber(), anyNumber(), anyNumber(), anyNumber()};
  return solution;
}

StageTrajectory anyTrajectory(const SceneSnapshot& scene, std::uint32_t solution, int index) {
  StageTrajectory stage{.solution = solution, .index = static_cast<std::uint32_t>(index)};
  stage.kind = static_cast<StageKind>(*rc::gen::inRange(1, kStageCount + 1));
  stage.robot = anyBool() ? scene.giver : scene.receiver;
  const int joints = *rc::gen::inRange(1, 4);
  for (int i = 0; i < joints; ++i) stage.joints.push_back(distinct("joint", i));
  stage.start = anyNumber();
  stage.t = several(1, 4, anyNumber);
  const auto row = [&] {
    std::vector<double> values(stage.joints.size());
    for (double& value : values) value = anyNumber();
    return values;
  };
  for (std::size_t i = 0; i < stage.t.size(); ++i) {
    stage.q.push_back(row());
    stage.qd.push_back(row());
  }
  stage.holding = several(0, 2, [&] {
    return Hold{scene.object, scene.receiver, anyName(), anyPose()};
  });
  stage.may_touch = several(0, 2, anyPair);
  return stage;
}

Outcome anyOutcome() {
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      return Done{anyCount(), anyBool()};
    case 1: {
      const int last = static_cast<int>(FailureReason::kInternal);
      return Failed{
          static_cast<FailureReason>(*rc::gen::inRange(1, last + 1)),
          {anyText(), anyText(), several(0, 3, anyReject), several(0, 3, anyOverride), anyText()}};
    }
    case 2:
      return Cancelled{};
    default:
      return Rejected{
          *rc::gen::element<std::string>("bad_request", "unknown_cell", "busy", "scene_changed"),
          several(0, 3, [] {
            return Fault{anyText(), anyText()};
          })};
  }
}

PlanEventPayload anyPayload() {
  switch (*rc::gen::inRange(0, 8)) {
    case 0:
      return Accepted{anyCount(), anyWhole()};
    case 1:
      return anyScene();
    case 2:
      return anyArms();
    case 3:
      return anyPruned();
    case 4:
      return anyCandidates();
    case 5:
      return anySolution(anyCount());
    case 6:
      return anyTrajectory(anyScene(), anyCount(), *rc::gen::inRange(0, 20));
    default:
      return anyOutcome();
  }
}

Variation anyVariation() {
  Variation variation{.path = anyName()};
  if (anyBool()) {
    variation.choices = several(1, 3, anyText);
    return variation;
  }
  const auto numbers = [](std::size_t count) {
    std::vector<double> all(count);
    for (double& number : all) number = anyNumber();
    return all;
  };
  const bool facing = anyBool();
  const std::size_t count = facing ? 3 : *rc::gen::inRange<std::size_t>(1, 5);
  variation.from = numbers(count);
  variation.to = numbers(count);
  if (facing) variation.facing = {anyNumber(), anyNumber()};
  return variation;
}

}  // namespace

PlanRequest anyRequest() {
  PlanRequest request{.id = anyId(), .client_id = "c-" + hexDigits(8), .cell = anyName()};
  request.task = anyText();
  request.object = anyText();
  if (anyBool()) request.X_WO_goal = anyPose();
  request.giver = anyText();
  request.receiver = anyText();
  request.giver_arm = anyText();
  request.receiver_arm = anyText();
  request.overrides = several(0, 4, anyOverride);
  if (anyBool()) request.expected_revision = anyWhole();
  request.mode = *rc::gen::element(SearchMode::kFirst, SearchMode::kBest, SearchMode::kAll);
  request.search = *rc::gen::element(SearchWidth::kPaper, SearchWidth::kWide);
  request.seed = anyWhole();
  if (anyBool()) request.deadline_s = anyPositive();
  request.speed_scale = *rc::gen::inRange(1, 1001) / 1000.0;
  return request;
}

DaemonStatus anyStatus() {
  DaemonStatus status;
  status.id = anyId().bytes;
  status.version = anyText();
  status.state = static_cast<DaemonState>(*rc::gen::inRange(1, 4));
  status.cells = several(0, 3, [] {
    return CellInfo{anyName(), several(0, 3, anyName), anyWhole(), several(0, 3, anyVariation)};
  });
  status.queued = anyCount();
  status.running = anyCount();
  status.counters = {anyWhole(), anyWhole(), anyWhole(), anyWhole(), anyWhole()};
  return status;
}

PlanEvent anyStage() { return {anyId(), anyCount(), anyPositive(), anyPayload()}; }

std::vector<PlanEvent> anyAnswer() {
  const SceneSnapshot scene = anyScene();
  std::vector<PlanEventPayload> payloads{Accepted{anyCount(), anyWhole()}, scene};
  for (const ArmSelected& arms : several(0, 2, anyArms)) payloads.emplace_back(arms);
  for (const GraspsPruned& pruned : several(0, 2, anyPruned)) payloads.emplace_back(pruned);
  for (const auto& candidates : several(0, 2, anyCandidates)) payloads.emplace_back(candidates);
  const std::uint32_t solutions = *rc::gen::inRange(1u, 3u);
  for (std::uint32_t solution = 0; solution < solutions; ++solution) {
    payloads.emplace_back(anySolution(solution));
    for (int i = 0; i < kStageCount; ++i) {
      payloads.emplace_back(anyTrajectory(scene, solution, i));
    }
  }
  payloads.emplace_back(Outcome{Done{solutions - 1, anyBool()}});
  const RequestId id = anyId();
  std::vector<PlanEvent> stages;
  for (std::uint32_t i = 0; i < payloads.size(); ++i) {
    stages.push_back({id, i, 0.001 * i, std::move(payloads[i])});
  }
  return stages;
}

}  // namespace handover::test
