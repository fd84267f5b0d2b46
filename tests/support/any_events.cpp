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

JointLimits anyLimits() {
  const double a = anyNumber(), b = anyNumber();
  JointLimits limits{std::min(a, b), std::max(a, b), anyPositive(), anyPositive(), anyPositive()};
  if (anyBool()) limits.lower = limits.upper = std::nullopt;
  return limits;
}

RobotSnapshot anyRobot(int number, const std::vector<std::string>& objects) {
  RobotSnapshot robot;
  robot.name = distinct("robot", number);
  robot.urdf = "robots/r" + anyName();
  robot.srdf = "robots/r" + anyName();
  robot.yaml = "robots/r" + anyName();
  robot.urdf_sha256 = hexDigits(64);
  robot.yaml_sha256 = hexDigits(64);
  robot.X_WB = anyPose();
  const int joints = *rc::gen::inRange(1, 4);
  for (int i = 0; i < joints; ++i) {
    const std::string joint = distinct("joint", i);
    robot.q_start.emplace_back(joint, anyNumber());
    robot.limits.emplace_back(joint, anyLimits());
  }
  robot.resting = several(0, 2, [&] { return NamePair{anyName(), *rc::gen::elementOf(objects)}; });
  return robot;
}

ArmName anyArm() { return {anyName(), anyName()}; }

std::array<double, 3> anyDirection() {
  std::array<double, 3> direction = anyVector();
  if (direction == std::array<double, 3>{}) direction[1] = -1;
  return direction;
}

RestSnapshot anyRest(const std::vector<std::string>& objects) {
  if (anyBool()) return {.none = true, .objects = {}};
  return {false, several(0, 3, [&] { return *rc::gen::elementOf(objects); })};
}

/// Not the unspecified one.
template <typename Enum>
Enum anyEnumerator() {
  return static_cast<Enum>(*rc::gen::inRange<int>(1, EnumNames<Enum>::value.size()));
}

SceneSnapshot anyScene() {
  SceneSnapshot scene;
  scene.cell = anyName();
  scene.task = anyText();
  scene.seed = anyWhole();
  scene.scene_hash = hexDigits(16);
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
  scene.start = {anyPose(), {}, anyRest(objects)};
  if (anyBool()) scene.start.held_by = ArmName{*rc::gen::elementOf(robots), anyName()};
  scene.goal = {anyPose(), anyEnumerator<TransportEnd>(), anyRest(objects)};
  if (anyBool()) {
    scene.upright = UprightSnapshot{anyDirection(), *rc::gen::inRange(0, 1801) * 0.1};
  }
  return scene;
}

Accepted anyAccepted() {
  Accepted accepted{.daemon_id = anyId().bytes, .epoch = anyWhole(), .program_version = anyText()};
  accepted.scene_revision = anyWhole();
  accepted.scene_hash = anyBool() ? hexDigits(16) : "";
  accepted.queue_place = anyCount();
  return accepted;
}

std::uint32_t anyPlace() { return *rc::gen::inRange(0u, 8u); }

StageRef anyStageRef() { return {anyPlace(), anyEnumerator<StageAction>()}; }

CauseCount anyCause() {
  CauseCount cause{.cause = anyEnumerator<Cause>(), .pair = {}, .stage = {}, .count = anyCount()};
  if (anyBool()) cause.pair = {anyName(), anyText()};
  if (anyBool()) cause.stage = anyStageRef();
  return cause;
}

ArmSelected anyArms() {
  return {several(0, 3, anyArm), several(0, 3, [] {
            const auto rejected =
                static_cast<Cause>(*rc::gen::inRange<int>(0, EnumNames<Cause>::value.size()));
            return ArmScore{anyArm(), anyPlace(), anyNumber(), rejected, anyText()};
          })};
}

GraspsPruned anyPruned() {
  return {anyArm(),   anyPlace(), anyEnumerator<PruningPlace>(),
          anyCount(), anyCount(), several(0, 3, anyCause)};
}

HandoverCandidates anyCandidates() {
  return {anyPlace(),
          anyArm(),
          anyArm(),
          anyCount(),
          anyCount(),
          anyCount(),
          anyCount(),
          anyCount(),
          several(0, 3, anyCause),
          several(0, 3, [] {
            return LatticeCell{{anyNumber(), anyNumber(), anyNumber()}, anyNumber()};
          })};
}

Holder anyHolder() {
  Holder holder{.arm = anyArm(), .tool_link = anyName()};
  if (anyBool()) {
    holder.gripper = FingerGripper{anyName(), several(0, 3, anyName)};
  } else {
    holder.gripper = SuctionGripper{anyName(), anyDirection(), anyPositive()};
  }
  holder.X_OT = anyPose();
  holder.grasp = anyCount();
  holder.dexterity = {anyNumber(), anyNumber()};
  return holder;
}

std::vector<std::pair<std::string, double>> anyNamedNumbers() {
  std::vector<std::pair<std::string, double>> all;
  const int count = *rc::gen::inRange(0, 3);
  for (int i = 0; i < count; ++i) all.emplace_back(distinct("n", i), anyNumber());
  return all;
}

Quality anyQuality() {
  Quality quality{.duration_s = anyNumber(), .bound_s = anyNumber(), .object_s = anyNumber()};
  quality.idle_s = anyNamedNumbers();
  quality.clearance = several(0, 3, [] {
    const std::string between = *rc::gen::element<std::string>("furniture", "robots", "object");
    return ClearanceQuality{between, anyNumber(), *rc::gen::inRange(0u, 128u),
                            anyBool() ? anyPair() : NamePair{}};
  });
  quality.tilt_deg = anyNumber();
  quality.object_turn_deg = {anyNumber(), anyNumber()};
  quality.limit_margin = anyNumber();
  quality.grip = several(0, 3, [] { return GripQuality{anyPlace(), anyNumber(), anyNumber()}; });
  quality.jerk_share = anyNumber();
  quality.cost = anyNumber();
  quality.terms = anyNamedNumbers();
  return quality;
}

Solution anySolution(std::uint32_t index, std::uint32_t stages) {
  Solution solution{.index = index, .holders = several(1, 4, anyHolder)};
  for (std::size_t i = 1; i < solution.holders.size(); ++i) {
    solution.X_WO_handovers.push_back(anyPose());
  }
  solution.stage_count = stages;
  solution.slack_s = *rc::gen::inRange(0, 1001) * 0.01;
  solution.cost = anyNumber();
  if (anyBool()) {
    solution.quality = anyQuality();
    solution.cost = solution.quality->cost;
  }
  return solution;
}

/// Strictly rising from 0.
std::vector<double> anyTimes() {
  std::vector<double> times{0};
  for (const double step : several(1, 4, [] { return *rc::gen::inRange(1, 100000) * 0.001; })) {
    times.push_back(times.back() + step);
  }
  return times;
}

StageTrajectory anyTrajectory(const SceneSnapshot& scene, std::uint32_t holders,
                              std::uint32_t solution, std::uint32_t index) {
  StageTrajectory stage{.solution = solution, .index = index};
  stage.holder = *rc::gen::inRange(0u, holders);
  stage.action = anyEnumerator<StageAction>();
  stage.robot = scene.robots[static_cast<std::size_t>(anyBool())].name;
  const int joints = *rc::gen::inRange(0, 4);
  for (int i = 0; i < joints; ++i) stage.joints.push_back(distinct("joint", i));
  stage.start = anyNumber();
  stage.t = anyTimes();
  const auto row = [&] {
    std::vector<double> values(stage.joints.size());
    for (double& value : values) value = anyNumber();
    return values;
  };
  for (std::size_t i = 0; i < stage.t.size(); ++i) {
    stage.q.push_back(row());
    stage.qd.push_back(row());
    stage.qdd.push_back(row());
  }
  stage.holding = several(0, 2, [&] {
    return Hold{scene.object, scene.robots[0].name, anyName(), anyPose()};
  });
  stage.may_touch = several(0, 2, anyPair);
  if (index > 0) {
    stage.after = several(0, 3, [&] {
      return StageProgress{*rc::gen::inRange(0u, index), anyPositive()};
    });
  }
  return stage;
}

Explanation anyExplanation() {
  Explanation why{.filter = anyText(), .text = anyText(), .exhaustive = anyBool()};
  why.causes = several(0, 3, anyCause);
  why.nearest_fix = several(0, 3, anyOverride);
  why.fix_text = anyText();
  if (anyBool()) {
    why.farthest = Farthest{anyPose(),
                            several(0, 3,
                                    [] {
                                      return FarthestTool{anyArm(), anyPose()};
                                    }),
                            anyStageRef()};
  }
  return why;
}

Outcome anyOutcome() {
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      return Done{anyCount(), anyBool()};
    case 1:
      return Failed{anyEnumerator<FailureReason>(), anyExplanation()};
    case 2:
      return Cancelled{anyEnumerator<CancelCause>()};
    default:
      return Rejected{anyEnumerator<RejectionReason>(), several(0, 3, [] {
                        return Fault{anyText(), anyText()};
                      })};
  }
}

Workspaces anyWorkspaces() {
  return {anyNumber(), several(0, 3, [] {
            ReachSlice slice{anyArm(), anyName(), {anyNumber(), anyNumber()}, anyPlace(), {}};
            const auto rows = slice.columns == 0 ? 0 : *rc::gen::inRange(0u, 4u);
            for (std::uint32_t i = 0; i < rows * slice.columns; ++i) {
              slice.scores.push_back(anyPositive());
            }
            return slice;
          })};
}

PlanEventPayload anyPayload() {
  switch (*rc::gen::inRange(0, 12)) {
    case 0:
      return anyAccepted();
    case 1:
      return anyScene();
    case 2:
      return anyArms();
    case 3:
      return anyPruned();
    case 4:
      return anyCandidates();
    case 5:
      return anySolution(anyCount(), *rc::gen::inRange(1u, 129u));
    case 6:
      return anyTrajectory(anyScene(), 8, anyCount(), *rc::gen::inRange(0u, 20u));
    case 7:
      return Note{anyName(), anyText()};
    case 8:
      return Failure{anyEnumerator<FailureReason>(), anyExplanation()};
    case 9:
      return Fix{several(0, 3, anyOverride), anyText()};
    case 10:
      return anyWorkspaces();
    default:
      return anyOutcome();
  }
}

std::vector<std::string> anyChain() {
  if (anyBool())
    return anyBool() ? std::vector<std::string>{kAutoChain} : std::vector<std::string>{};
  return several(1, 5, [] { return anyBool() ? anyName() : anyName() + "/" + anyName(); });
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
  request.chain = anyChain();
  request.overrides = several(0, 4, anyOverride);
  if (anyBool()) request.expected_revision = anyWhole();
  if (anyBool()) request.expected_hash = hexDigits(16);
  request.mode = anyEnumerator<SearchMode>();
  request.search = anyEnumerator<SearchWidth>();
  request.objective = anyBool() ? anyEnumerator<Objective>() : Objective::kUnspecified;
  request.seed = anyWhole();
  if (anyBool()) request.deadline_s = anyPositive();
  request.speed_scale = *rc::gen::inRange(1, 1001) / 1000.0;
  request.slack_s = *rc::gen::inRange(0, 1001) * 0.01;
  request.wants_fix = anyBool();
  return request;
}

DaemonStatus anyStatus() {
  DaemonStatus status;
  status.id = anyId().bytes;
  status.version = anyText();
  status.state = anyEnumerator<DaemonState>();
  status.cells = several(0, 3, [] {
    CellInfo cell{anyName(), several(0, 3, anyName), anyWhole(), several(0, 3, anyVariation),
                  anyBool() ? hexDigits(16) : ""};
    cell.role = anyEnumerator<CellRole>();
    if (cell.role == CellRole::kLeader || cell.role == CellRole::kStandby) cell.epoch = anyCount();
    return cell;
  });
  status.queued = anyCount();
  status.running = anyCount();
  status.counters = {anyWhole(), anyWhole(), anyWhole(), anyWhole(), anyWhole()};
  status.refused = anyWhole();
  status.clients = anyCount();
  status.memory_bytes = anyWhole();
  status.dropped_packets = anyWhole();
  status.uptime_s = anyPositive();
  if (anyBool()) status.answer_times = {anyPositive(), anyPositive()};
  status.kept_requests = anyCount();
  status.answered = several(0, 130, anyId);
  return status;
}

PlanEvent anyEvent() { return {anyId(), anyId().bytes, anyCount(), anyPositive(), anyPayload()}; }

std::vector<PlanEvent> anyAnswer() {
  const SceneSnapshot scene = anyScene();
  std::vector<PlanEventPayload> payloads{anyAccepted(), scene};
  for (const ArmSelected& arms : several(0, 2, anyArms)) payloads.emplace_back(arms);
  for (const GraspsPruned& pruned : several(0, 2, anyPruned)) payloads.emplace_back(pruned);
  for (const auto& candidates : several(0, 2, anyCandidates)) payloads.emplace_back(candidates);
  const std::uint32_t solutions = *rc::gen::inRange(1u, 3u);
  for (std::uint32_t index = 0; index < solutions; ++index) {
    const std::uint32_t stages = *rc::gen::inRange(1u, 20u);
    const Solution solution = anySolution(index, stages);
    payloads.emplace_back(solution);
    for (std::uint32_t i = 0; i < stages; ++i) {
      const auto holders = static_cast<std::uint32_t>(solution.holders.size());
      payloads.emplace_back(anyTrajectory(scene, holders, index, i));
    }
  }
  payloads.emplace_back(Outcome{Done{solutions - 1, anyBool()}});
  const RequestId id = anyId();
  const AnswerId answer = anyId().bytes;
  std::vector<PlanEvent> events;
  for (std::uint32_t i = 0; i < payloads.size(); ++i) {
    events.push_back({id, answer, i, 0.001 * i, std::move(payloads[i])});
  }
  return events;
}

}  // namespace handover::test
