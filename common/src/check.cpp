// SPDX-License-Identifier: Apache-2.0
#include <handover/common/check.hpp>

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

/// Collects faults; paths are only put together where there is one.
class Checker {
 public:
  std::vector<Fault> faults;

  void fault(const std::string& field, const std::string& message) {
    if (faults.size() < bounds::kFaults) faults.push_back({field.substr(0, 512), message});
  }

  void text(const std::string& field, const std::string& value, std::size_t most) {
    if (value.size() > most) {
      fault(field, "longer than " + std::to_string(most) + " bytes");
    } else if (value.find('\0') != std::string::npos) {
      fault(field, "holds a zero byte");
    }
  }

  void name(const std::string& field, const std::string& value) {
    text(field, value, bounds::kName);
  }

  void required(const std::string& field, const std::string& value) {
    if (value.empty()) fault(field, "is missing");
    name(field, value);
  }

  /// False, and a fault, when there are more than `most`.
  bool count(const std::string& field, std::size_t size, std::size_t most) {
    if (size <= most) return true;
    fault(field, "more than " + std::to_string(most) + " entries");
    return false;
  }

  void finite(const std::string& field, double value) {
    if (!std::isfinite(value)) fault(field, "is not finite");
  }

  void pose(const std::string& field, const PoseValue& X) {
    for (const double c : X.xyz) {
      if (!std::isfinite(c)) return fault(field + ".xyz", "is not finite");
    }
    double square = 0;
    for (const double c : X.quat_wxyz) {
      if (!std::isfinite(c)) return fault(field + ".quat_wxyz", "is not finite");
      square += c * c;
    }
    if (!(std::abs(std::sqrt(square) - 1.0) <= 1e-3)) {
      fault(field + ".quat_wxyz", "is off unit length by more than 0.001");
    }
  }

  template <typename Items, typename Each>
  void list(const std::string& field, const Items& items, std::size_t most, Each each) {
    if (!count(field, items.size(), most)) return;
    std::size_t i = 0;
    for (const auto& item : items) each(field + "[" + std::to_string(i++) + "]", item);
  }

  void names(const std::string& field, const std::vector<std::string>& items, std::size_t most) {
    list(field, items, most, [this](const auto& at, const auto& item) { name(at, item); });
  }

  void pairs(const std::string& field, const std::vector<NamePair>& items) {
    list(field, items, bounds::kPairs, [this](const auto& at, const NamePair& item) {
      name(at, item.first);
      name(at, item.second);
    });
  }

  void overrides(const std::string& field, const std::vector<Override>& items) {
    list(field, items, bounds::kOverrides, [this](const auto& at, const Override& item) {
      if (item.path.empty()) fault(at + ".path", "is missing");
      text(at + ".path", item.path, bounds::kOverridePath);
      text(at + ".value", item.value, bounds::kText);
    });
  }

  /// A fault unless it is an enumerator with a name.
  template <typename Enum>
  void enumerator(const std::string& field, Enum value, const char* what) {
    if (!known(value) || value == Enum{}) fault(field, std::string("unknown ") + what);
  }

  void hexDigits(const std::string& field, const std::string& value) {
    name(field, value);
    if (value.find_first_not_of("0123456789abcdef") != std::string::npos) {
      fault(field, "is not in hex digits");
    }
  }

  void sha256(const std::string& field, const std::string& value) {
    hexDigits(field, value);
    if (!value.empty() && value.size() != 64) fault(field, "must have 64 hex digits");
  }

  void range(const std::string& field, double value, double least, double most,
             const char* message) {
    if (!(value >= least && value <= most)) fault(field, message);
  }

  void slack(const std::string& field, double value) {
    range(field, value, 0, bounds::kSlack, "must be in [0, 10]");
  }

  void vector(const std::string& field, const std::array<double, 3>& v) {
    for (const double c : v) finite(field, c);
  }

  void direction(const std::string& field, const std::array<double, 3>& v) {
    vector(field, v);
    if (v == std::array<double, 3>{}) fault(field, "is zero");
  }

  void arm(const std::string& field, const ArmName& item) {
    name(field + ".robot", item.robot);
    name(field + ".arm", item.arm);
  }

  void holder(const std::string& field, std::uint32_t place) {
    if (place >= bounds::kHolders) fault(field, "is no place in a chain");
  }

  void stage(const std::string& field, std::uint32_t index) {
    if (index >= bounds::kStages) fault(field, "is no place in a plan");
  }

  void stageRef(const std::string& field, const StageRef& ref) {
    holder(field + ".holder", ref.holder);
    enumerator(field + ".action", ref.action, "action");
  }

  void causes(const std::string& field, const std::vector<CauseCount>& items) {
    list(field, items, bounds::kPairs, [this](const auto& at, const CauseCount& item) {
      enumerator(at + ".cause", item.cause, "cause");
      name(at + ".pair", item.pair.first);
      name(at + ".pair", item.pair.second);
      if (item.stage) stageRef(at + ".stage", *item.stage);
    });
  }

  void namedNumbers(const std::string& field,
                    const std::vector<std::pair<std::string, double>>& items, std::size_t most) {
    list(field, items, most, [this](const auto& at, const auto& item) {
      name(at, item.first);
      finite(at, item.second);
    });
  }

  void numbers(const std::string& field, const std::vector<double>& values) {
    if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
      fault(field, "holds a number that is not finite");
    }
  }
};

void checkGeometry(Checker& c, const std::string& field, const Geometry& geometry, bool part) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    for (const double edge : box->size) c.finite(field + ".size", edge);
  } else if (const auto* sphere = std::get_if<SphereGeometry>(&geometry)) {
    c.finite(field + ".radius", sphere->radius);
  } else if (const auto* cylinder = std::get_if<CylinderGeometry>(&geometry)) {
    c.finite(field + ".radius", cylinder->radius);
    c.finite(field + ".length", cylinder->length);
  } else if (const auto* mesh = std::get_if<MeshGeometry>(&geometry)) {
    c.text(field + ".path", mesh->path, bounds::kPath);
    for (const double s : mesh->scale) c.finite(field + ".scale", s);
  } else if (const auto* compound = std::get_if<CompoundGeometry>(&geometry)) {
    if (part) return c.fault(field, "is a compound within a compound");
    c.list(field + ".parts", compound->parts, bounds::kParts,
           [&c](const std::string& at, const GeometryPart& item) {
             c.pose(at + ".X_OS", item.X_OS);
             checkGeometry(c, at + ".geometry", item.geometry, true);
           });
  }
}

void checkLimits(Checker& c, const std::string& at, const JointLimits& limits) {
  if (limits.lower.has_value() != limits.upper.has_value()) {
    c.fault(at, "has only one of lower and upper");
  }
  for (const double v : {limits.lower.value_or(0), limits.upper.value_or(0), limits.velocity,
                         limits.acceleration, limits.jerk}) {
    c.finite(at, v);
  }
}

void checkRobot(Checker& c, const std::string& field, const RobotSnapshot& robot) {
  c.required(field + ".name", robot.name);
  c.text(field + ".urdf", robot.urdf, bounds::kPath);
  c.text(field + ".srdf", robot.srdf, bounds::kPath);
  c.text(field + ".yaml", robot.yaml, bounds::kPath);
  c.sha256(field + ".urdf_sha256", robot.urdf_sha256);
  c.sha256(field + ".yaml_sha256", robot.yaml_sha256);
  c.pose(field + ".X_WB", robot.X_WB);
  c.namedNumbers(field + ".q_start", robot.q_start, bounds::kJoints);
  c.list(field + ".limits", robot.limits, bounds::kJoints,
         [&c](const std::string& at, const auto& item) {
           c.name(at, item.first);
           checkLimits(c, at, item.second);
         });
  c.pairs(field + ".resting", robot.resting);
}

void checkObject(Checker& c, const std::string& field, const ObjectSnapshot& object) {
  c.required(field + ".name", object.name);
  checkGeometry(c, field + ".geometry", object.geometry, false);
  c.pose(field + ".X_WO", object.X_WO);
  if (object.attached_to) {
    c.name(field + ".attached_to.robot", object.attached_to->robot);
    c.name(field + ".attached_to.link", object.attached_to->link);
    c.pose(field + ".attached_to.X_LO", object.attached_to->X_LO);
    c.names(field + ".attached_to.touch_links", object.attached_to->touch_links, bounds::kJoints);
  }
  c.names(field + ".resting", object.resting, bounds::kObjects);
}

void checkRest(Checker& c, const std::string& field, const RestSnapshot& rest) {
  c.names(field, rest.objects, bounds::kObjects);
  if (rest.none && !rest.objects.empty()) c.fault(field, "lists objects beside none");
}

void checkPayload(Checker& c, const Accepted& accepted) {
  c.name("accepted.program_version", accepted.program_version);
  c.hexDigits("accepted.scene_hash", accepted.scene_hash);
}

void checkPayload(Checker& c, const SceneSnapshot& scene) {
  c.required("scene.cell", scene.cell);
  c.name("scene.task", scene.task);
  c.hexDigits("scene.scene_hash", scene.scene_hash);
  c.name("scene.object", scene.object);
  c.list("scene.robots", scene.robots, bounds::kRobots,
         [&c](const auto& at, const auto& item) { checkRobot(c, at, item); });
  c.list("scene.objects", scene.objects, bounds::kObjects,
         [&c](const auto& at, const auto& item) { checkObject(c, at, item); });
  c.pose("scene.start.X_WO", scene.start.X_WO);
  if (scene.start.held_by) c.arm("scene.start.held_by", *scene.start.held_by);
  checkRest(c, "scene.start.rest", scene.start.rest);
  c.pose("scene.goal.X_WO", scene.goal.X_WO);
  c.enumerator("scene.goal.end", scene.goal.end, "end");
  checkRest(c, "scene.goal.rest", scene.goal.rest);
  if (!scene.upright) return;
  c.direction("scene.upright.axis", scene.upright->axis);
  c.range("scene.upright.within_deg", scene.upright->within_deg, 0, 180, "must be in [0, 180]");
}

void checkPayload(Checker& c, const ArmSelected& arms) {
  c.list("arm_selected.holders", arms.holders, bounds::kHolders,
         [&c](const auto& at, const ArmName& item) { c.arm(at, item); });
  c.list("arm_selected.scores", arms.scores, bounds::kScores,
         [&c](const auto& at, const ArmScore& item) {
           c.arm(at, item.arm);
           c.holder(at + ".holder", item.holder);
           c.finite(at + ".manipulability", item.manipulability);
           if (!known(item.rejected)) c.fault(at + ".rejected", "unknown cause");
           c.name(at + ".object", item.object);
         });
}

void checkPayload(Checker& c, const GraspsPruned& pruned) {
  c.arm("grasps_pruned.arm", pruned.arm);
  c.holder("grasps_pruned.holder", pruned.holder);
  c.enumerator("grasps_pruned.place", pruned.place, "place");
  c.causes("grasps_pruned.causes", pruned.causes);
}

void checkPayload(Checker& c, const HandoverCandidates& candidates) {
  c.holder("handover_candidates.handover", candidates.handover);
  c.arm("handover_candidates.giver", candidates.giver);
  c.arm("handover_candidates.receiver", candidates.receiver);
  c.causes("handover_candidates.causes", candidates.causes);
  // Hundreds of cells in most answers: no text for each.
  const std::string lattice = "handover_candidates.lattice";
  if (!c.count(lattice, candidates.lattice.size(), bounds::kLattice)) return;
  for (std::size_t i = 0; i < candidates.lattice.size(); ++i) {
    const auto& [centre, score] = candidates.lattice[i];
    const bool finite =
        std::isfinite(score) &&
        std::all_of(centre.begin(), centre.end(), [](double v) { return std::isfinite(v); });
    if (!finite) c.fault(lattice + "[" + std::to_string(i) + "]", "is not finite");
  }
}

void checkHolder(Checker& c, const std::string& at, const Holder& holder) {
  c.arm(at, holder.arm);
  c.name(at + ".tool_link", holder.tool_link);
  if (const auto* hand = std::get_if<FingerGripper>(&holder.gripper)) {
    c.name(at + ".hand.palm", hand->palm_link);
    c.names(at + ".hand.fingers", hand->finger_links, bounds::kJoints);
  } else if (const auto* cup = std::get_if<SuctionGripper>(&holder.gripper)) {
    c.name(at + ".hand.cup_link", cup->cup_link);
    c.direction(at + ".hand.axis", cup->axis);
    c.finite(at + ".hand.radius", cup->radius);
  }
  c.pose(at + ".X_OT", holder.X_OT);
  c.finite(at + ".dexterity.take", holder.dexterity.take);
  c.finite(at + ".dexterity.give", holder.dexterity.give);
}

void checkQuality(Checker& c, const std::string& at, const Quality& quality) {
  c.namedNumbers(at + ".idle_s", quality.idle_s, bounds::kRobots);
  c.list(at + ".clearance", quality.clearance, bounds::kQualities,
         [&c](const auto& field, const ClearanceQuality& item) {
           static constexpr std::string_view kBetween[] = {"furniture", "robots", "object"};
           if (std::find(std::begin(kBetween), std::end(kBetween), item.between) ==
               std::end(kBetween)) {
             c.fault(field + ".between", "is none of furniture, robots, object");
           }
           c.finite(field + ".least_m", item.least_m);
           c.stage(field + ".stage", item.stage);
           c.name(field + ".pair", item.pair.first);
           c.name(field + ".pair", item.pair.second);
         });
  c.list(at + ".grip", quality.grip, bounds::kHolders,
         [&c](const auto& field, const GripQuality& item) {
           c.holder(field + ".holder", item.holder);
           c.finite(field, item.quality);
           c.finite(field, item.of_best);
         });
  c.namedNumbers(at + ".terms", quality.terms, bounds::kQualities);
  for (const double v : {quality.duration_s, quality.bound_s, quality.object_s, quality.tilt_deg,
                         quality.object_turn_deg[0], quality.object_turn_deg[1],
                         quality.limit_margin, quality.jerk_share, quality.cost}) {
    c.finite(at, v);
  }
}

void checkPayload(Checker& c, const Solution& solution) {
  const std::string at = "solution";
  if (solution.holders.empty()) c.fault(at + ".holders", "is missing");
  c.list(at + ".holders", solution.holders, bounds::kHolders,
         [&c](const auto& field, const Holder& item) { checkHolder(c, field, item); });
  c.list(at + ".X_WO_handovers", solution.X_WO_handovers, bounds::kHolders,
         [&c](const auto& field, const PoseValue& item) { c.pose(field, item); });
  if (solution.X_WO_handovers.size() + 1 != solution.holders.size()) {
    c.fault(at + ".X_WO_handovers", "must have one entry fewer than holders");
  }
  if (solution.stage_count < 1 || solution.stage_count > bounds::kStages) {
    c.fault(at + ".stage_count", "must be from 1 to 128");
  }
  c.slack(at + ".slack_s", solution.slack_s);
  c.finite(at + ".cost", solution.cost);
  if (solution.quality) checkQuality(c, at + ".quality", *solution.quality);
}

void checkTimes(Checker& c, const std::string& field, const std::vector<double>& t) {
  c.numbers(field, t);
  const bool rises = t.size() >= 2 && t[0] == 0 &&
                     std::adjacent_find(t.begin(), t.end(),
                                        [](double a, double b) { return !(a < b); }) == t.end();
  if (!rises) c.fault(field, "must rise strictly from 0, with two entries or more");
}

void checkPayload(Checker& c, const StageTrajectory& stage) {
  const std::string at = "trajectory";
  c.stage(at + ".index", stage.index);
  c.holder(at + ".holder", stage.holder);
  c.enumerator(at + ".action", stage.action, "action");
  c.required(at + ".robot", stage.robot);
  c.names(at + ".joints", stage.joints, bounds::kJoints);
  c.finite(at + ".start", stage.start);
  if (!c.count(at + ".t", stage.t.size(), bounds::kSamples)) return;
  checkTimes(c, at + ".t", stage.t);
  const auto rows = [&](const std::string& field, const std::vector<std::vector<double>>& values) {
    if (values.size() != stage.t.size()) c.fault(field, "length differs from t");
    for (const auto& row : values) {
      if (row.size() != stage.joints.size()) {
        c.fault(field, "has a row that does not fit the joints");
        return;
      }
      c.numbers(field, row);
    }
  };
  rows(at + ".q", stage.q);
  rows(at + ".qd", stage.qd);
  rows(at + ".qdd", stage.qdd);
  c.list(at + ".holding", stage.holding, bounds::kObjects,
         [&c](const std::string& field, const Hold& hold) {
           c.name(field, hold.object);
           c.name(field, hold.robot);
           c.name(field, hold.link);
           c.pose(field + ".X_LO", hold.X_LO);
         });
  c.pairs(at + ".may_touch", stage.may_touch);
  c.list(at + ".after", stage.after, bounds::kStages,
         [&c](const std::string& field, const StageProgress& item) {
           c.stage(field, item.stage);
           if (!std::isfinite(item.progress) || item.progress < 0) {
             c.fault(field, "must be finite and 0 or more");
           }
         });
}

void checkPayload(Checker& c, const Note& note) {
  c.required("note.code", note.code);
  c.text("note.text", note.text, bounds::kText);
}

void checkExplanation(Checker& c, const std::string& at, const Explanation& why) {
  c.name(at + ".filter", why.filter);
  c.text(at + ".text", why.text, bounds::kText);
  c.text(at + ".fix_text", why.fix_text, bounds::kText);
  c.causes(at + ".causes", why.causes);
  c.overrides(at + ".nearest_fix", why.nearest_fix);
  if (!why.farthest) return;
  c.pose(at + ".farthest.X_WO", why.farthest->X_WO);
  c.list(at + ".farthest.tools", why.farthest->tools, bounds::kHolders,
         [&c](const auto& field, const FarthestTool& item) {
           c.arm(field, item.arm);
           c.pose(field + ".X_WT", item.X_WT);
         });
  c.stageRef(at + ".farthest.stage", why.farthest->stage);
}

void checkPayload(Checker& c, const Failure& failure) {
  c.enumerator("failure.reason", failure.reason, "failure reason");
  checkExplanation(c, "failure.explanation", failure.explanation);
}

void checkPayload(Checker& c, const Fix& fix) {
  c.overrides("fix.overrides", fix.overrides);
  c.text("fix.text", fix.text, bounds::kText);
}

void checkOutcome(Checker&, const Done&) {}

void checkOutcome(Checker& c, const Failed& failed) {
  c.enumerator("outcome.reason", failed.reason, "failure reason");
  checkExplanation(c, "outcome.explanation", failed.explanation);
}

void checkOutcome(Checker& c, const Cancelled& cancelled) {
  c.enumerator("outcome.cause", cancelled.cause, "cause of a cancel");
}

void checkOutcome(Checker& c, const Rejected& rejected) {
  c.enumerator("outcome.reason", rejected.reason, "rejection reason");
  c.list("outcome.faults", rejected.faults, bounds::kFaults,
         [&c](const std::string& at, const Fault& item) {
           c.text(at + ".field", item.field, bounds::kOverridePath);
           c.text(at + ".message", item.message, bounds::kText);
         });
}

void checkSlice(Checker& c, const std::string& at, const ReachSlice& slice) {
  c.arm(at + ".arm", slice.arm);
  c.name(at + ".tool_link", slice.tool_link);
  for (const double coordinate : slice.first) c.finite(at + ".first", coordinate);
  if (!c.count(at + ".scores", slice.scores.size(), bounds::kSliceCells)) return;
  const bool whole_rows =
      slice.columns == 0 ? slice.scores.empty() : slice.scores.size() % slice.columns == 0;
  if (!whole_rows) c.fault(at + ".scores", "has no whole rows");
  const auto good = [](double score) { return std::isfinite(score) && score >= 0; };
  if (!std::all_of(slice.scores.begin(), slice.scores.end(), good)) {
    c.fault(at + ".scores", "holds one that is not finite, or below 0");
  }
}

void checkPayload(Checker& c, const Workspaces& workspaces) {
  c.finite("workspaces.z", workspaces.z);
  c.list("workspaces.slices", workspaces.slices, bounds::kSlices,
         [&c](const auto& at, const ReachSlice& item) { checkSlice(c, at, item); });
}

void checkPayload(Checker& c, const Outcome& outcome) {
  std::visit([&c](const auto& value) { checkOutcome(c, value); }, outcome);
}

void checkChain(Checker& c, const std::vector<std::string>& chain) {
  if (chain == std::vector<std::string>{kAutoChain}) return;
  c.list("chain", chain, bounds::kHolders, [&c](const auto& at, const std::string& item) {
    c.name(at, item);
    if (item == kAutoChain) {
      c.fault(at, "auto must stand alone");
    } else if (!holderOf(item)) {
      c.fault(at, "must be ROBOT or ROBOT/ARM");
    }
  });
}

void checkVariation(Checker& c, const std::string& at, const Variation& variation) {
  if (variation.path.empty()) c.fault(at + ".path", "is missing");
  c.text(at + ".path", variation.path, bounds::kOverridePath);
  c.list(at + ".choices", variation.choices, bounds::kChoices,
         [&c](const std::string& field, const auto& item) { c.text(field, item, bounds::kText); });
  c.count(at + ".from", variation.from.size(), bounds::kRangeSize);
  c.numbers(at + ".from", variation.from);
  c.numbers(at + ".to", variation.to);
  if (variation.from.size() != variation.to.size()) {
    c.fault(at + ".to", "length differs from the other end's");
  }
  if (variation.from.empty() == variation.choices.empty()) {
    c.fault(at, "must have either a range or choices");
  }
  if (!variation.facing) return;
  for (const double coordinate : *variation.facing) c.finite(at + ".facing", coordinate);
  if (variation.from.size() != 3) c.fault(at + ".facing", "is not beside a range of rpy_deg");
}

}  // namespace

bool validClientId(std::string_view text) {
  if (text.empty() || text.size() > 64) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::optional<ArmName> holderOf(std::string_view text) {
  const auto slash = text.find('/');
  const std::string_view robot = text.substr(0, slash);
  if (robot.empty()) return std::nullopt;
  if (slash == std::string_view::npos) return ArmName{std::string(robot), ""};
  const std::string_view arm = text.substr(slash + 1);
  if (arm.empty() || arm.find('/') != std::string_view::npos) return std::nullopt;
  return ArmName{std::string(robot), std::string(arm)};
}

std::vector<Fault> check(const PlanRequest& request) {
  Checker c;
  if (request.id == RequestId{}) c.fault("request_id", "is missing");
  if (!validClientId(request.client_id)) c.fault("client_id", "must match [a-z0-9_-]{1,64}");
  c.required("cell", request.cell);
  c.name("task", request.task);
  c.name("object_name", request.object);
  if (request.X_WO_goal) c.pose("X_WO_goal", *request.X_WO_goal);
  checkChain(c, request.chain);
  c.overrides("overrides", request.overrides);
  c.hexDigits("expected_hash", request.expected_hash);
  c.enumerator("mode", request.mode, "mode");
  c.enumerator("search", request.search, "search");
  if (!known(request.objective)) c.fault("objective", "unknown objective");
  if (request.deadline_s && !(std::isfinite(*request.deadline_s) && *request.deadline_s > 0)) {
    c.fault("deadline_s", "must be finite and above 0");
  }
  if (!(request.speed_scale > 0 && request.speed_scale <= 1)) {
    c.fault("speed_scale", "must be in (0, 1]");
  } else if (request.speed_scale < bounds::kSlowest) {
    c.fault("speed_scale", "is below 0.001");
  }
  c.slack("slack_s", request.slack_s);
  return std::move(c.faults);
}

std::vector<Fault> check(const PlanEvent& event) {
  Checker c;
  if (event.answer_id == AnswerId{}) c.fault("answer_id", "is missing");
  c.finite("elapsed_s", event.elapsed_s);
  std::visit([&c](const auto& payload) { checkPayload(c, payload); }, event.payload);
  return std::move(c.faults);
}

std::vector<Fault> check(const DaemonStatus& status) {
  Checker c;
  c.name("version", status.version);
  c.enumerator("state", status.state, "state");
  c.list("cells", status.cells, bounds::kCells, [&c](const std::string& at, const CellInfo& cell) {
    c.required(at + ".name", cell.name);
    c.names(at + ".tasks", cell.tasks, bounds::kCells);
    c.hexDigits(at + ".scene_hash", cell.scene_hash);
    c.list(at + ".variations", cell.variations, bounds::kVariations,
           [&c](const auto& field, const Variation& item) { checkVariation(c, field, item); });
  });
  return std::move(c.faults);
}

std::vector<Fault> check(const Variation& variation) {
  Checker c;
  checkVariation(c, "vary", variation);
  return std::move(c.faults);
}

std::string describe(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) text += " " + fault.field + " " + fault.message + ";";
  return text;
}

bool serves(const DaemonStatus& daemon, std::string_view cell) {
  return std::any_of(daemon.cells.begin(), daemon.cells.end(),
                     [&](const CellInfo& info) { return info.name == cell; });
}

std::string placePath(const Variation& facing) {
  return facing.path.substr(0, facing.path.rfind('.') + 1) + "xyz";
}

}  // namespace handover
