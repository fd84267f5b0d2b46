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

  void rejects(const std::string& field, const std::vector<RejectCount>& items) {
    list(field, items, bounds::kPairs, [this](const auto& at, const RejectCount& item) {
      name(at + ".cause", item.cause);
      name(at + ".pair", item.pair.first);
      name(at + ".pair", item.pair.second);
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

void checkRobot(Checker& c, const std::string& field, const RobotSnapshot& robot) {
  c.required(field + ".name", robot.name);
  c.text(field + ".urdf", robot.urdf, bounds::kPath);
  c.text(field + ".srdf", robot.srdf, bounds::kPath);
  c.name(field + ".urdf_sha256", robot.urdf_sha256);
  c.pose(field + ".X_WB", robot.X_WB);
  c.list(field + ".q_start", robot.q_start, bounds::kJoints,
         [&c](const std::string& at, const auto& item) {
           c.name(at, item.first);
           c.finite(at, item.second);
         });
  c.list(field + ".limits", robot.limits, bounds::kJoints,
         [&c](const std::string& at, const auto& item) {
           c.name(at, item.first);
           const JointLimits& l = item.second;
           for (const double v : {l.lower, l.upper, l.velocity, l.acceleration}) c.finite(at, v);
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

void checkPayload(Checker&, const Accepted&) {}

void checkPayload(Checker& c, const SceneSnapshot& scene) {
  c.required("scene.cell", scene.cell);
  c.name("scene.task", scene.task);
  c.name("scene.scene_hash", scene.scene_hash);
  c.name("scene.object", scene.object);
  c.name("scene.giver", scene.giver);
  c.name("scene.receiver", scene.receiver);
  c.pose("scene.X_WO_start", scene.X_WO_start);
  c.pose("scene.X_WO_goal", scene.X_WO_goal);
  c.list("scene.robots", scene.robots, bounds::kRobots,
         [&c](const auto& at, const auto& item) { checkRobot(c, at, item); });
  c.list("scene.objects", scene.objects, bounds::kObjects,
         [&c](const auto& at, const auto& item) { checkObject(c, at, item); });
}

void checkPayload(Checker& c, const ArmSelected& arms) {
  c.name("arm_selected.giver_arm", arms.giver_arm);
  c.name("arm_selected.receiver_arm", arms.receiver_arm);
  c.list("arm_selected.scores", arms.scores, bounds::kObjects,
         [&c](const auto& at, const ArmScore& item) {
           c.name(at + ".robot", item.robot);
           c.name(at + ".arm", item.arm);
           c.finite(at + ".manipulability", item.manipulability);
           c.text(at + ".rejected", item.rejected, bounds::kText);
         });
}

void checkPayload(Checker& c, const GraspsPruned& pruned) {
  c.name("grasps_pruned.robot", pruned.robot);
  c.name("grasps_pruned.arm", pruned.arm);
  c.rejects("grasps_pruned.rejects", pruned.rejects);
}

void checkPayload(Checker& c, const HandoverCandidates& candidates) {
  c.name("handover_candidates.giver_arm", candidates.giver_arm);
  c.name("handover_candidates.receiver_arm", candidates.receiver_arm);
  c.rejects("handover_candidates.rejects", candidates.rejects);
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

void checkPayload(Checker& c, const Solution& solution) {
  for (const auto* text : {&solution.giver_arm, &solution.receiver_arm, &solution.giver_tool_link,
                           &solution.receiver_tool_link}) {
    c.name("solution", *text);
  }
  c.pose("solution.X_WO_handover", solution.X_WO_handover);
  c.pose("solution.X_OT_giver", solution.X_OT_giver);
  c.pose("solution.X_OT_receiver", solution.X_OT_receiver);
  const Dexterity& d = solution.dexterity;
  for (const double v : {d.receiver_place, d.receiver_handover, d.giver_pick, d.giver_handover}) {
    c.finite("solution.dexterity", v);
  }
}

void checkPayload(Checker& c, const StageTrajectory& stage) {
  const std::string at = "trajectory";
  const int kind = static_cast<int>(stage.kind);
  if (kind < 1 || kind > kStageCount) c.fault(at + ".kind", "is not a stage");
  c.required(at + ".robot", stage.robot);
  c.names(at + ".joints", stage.joints, bounds::kJoints);
  c.finite(at + ".start", stage.start);
  if (!c.count(at + ".t", stage.t.size(), bounds::kSamples)) return;
  c.numbers(at + ".t", stage.t);
  const auto rows = [&](const std::string& field, const std::vector<std::vector<double>>& values) {
    if (values.size() != stage.t.size()) c.fault(field, "has another length than t");
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
  c.list(at + ".holding", stage.holding, bounds::kObjects,
         [&c](const std::string& field, const Hold& hold) {
           c.name(field, hold.object);
           c.name(field, hold.robot);
           c.name(field, hold.link);
           c.pose(field + ".X_LO", hold.X_LO);
         });
  c.pairs(at + ".may_touch", stage.may_touch);
}

void checkPayload(Checker& c, const Outcome& outcome) {
  if (const auto* failed = std::get_if<Failed>(&outcome)) {
    const int reason = static_cast<int>(failed->reason);
    if (reason < 1 || reason > static_cast<int>(FailureReason::kInternal)) {
      c.fault("outcome.reason", "is not a reason");
    }
    c.name("outcome.explanation.filter", failed->explanation.filter);
    c.text("outcome.explanation.text", failed->explanation.text, bounds::kText);
    c.text("outcome.explanation.fix_text", failed->explanation.fix_text, bounds::kText);
    c.rejects("outcome.explanation.causes", failed->explanation.causes);
    c.overrides("outcome.explanation.nearest_fix", failed->explanation.nearest_fix);
  } else if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    static constexpr std::string_view kReasons[] = {"bad_request", "unknown_cell", "busy",
                                                    "scene_changed"};
    if (std::find(std::begin(kReasons), std::end(kReasons), rejected->reason) ==
        std::end(kReasons)) {
      c.fault("outcome.reason", "is not a reason");
    }
    c.list("outcome.faults", rejected->faults, bounds::kFaults,
           [&c](const std::string& at, const Fault& item) {
             c.text(at + ".field", item.field, bounds::kOverridePath);
             c.text(at + ".message", item.message, bounds::kText);
           });
  }
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
    c.fault(at + ".to", "has another length than from");
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

std::vector<Fault> check(const PlanRequest& request) {
  Checker c;
  if (request.id == RequestId{}) c.fault("request_id", "is missing");
  if (!validClientId(request.client_id)) c.fault("client_id", "must match [a-z0-9_-]{1,64}");
  c.required("cell", request.cell);
  for (const auto& [field, value] :
       {std::pair{"task", &request.task}, std::pair{"object_name", &request.object},
        std::pair{"giver", &request.giver}, std::pair{"receiver", &request.receiver},
        std::pair{"giver_arm", &request.giver_arm},
        std::pair{"receiver_arm", &request.receiver_arm}}) {
    c.name(field, *value);
  }
  if (request.X_WO_goal) c.pose("X_WO_goal", *request.X_WO_goal);
  c.overrides("overrides", request.overrides);
  if (request.mode != SearchMode::kFirst && request.mode != SearchMode::kBest &&
      request.mode != SearchMode::kAll) {
    c.fault("mode", "is not a mode");
  }
  if (request.search != SearchWidth::kPaper && request.search != SearchWidth::kWide) {
    c.fault("search", "is not a search");
  }
  if (request.deadline_s && !(std::isfinite(*request.deadline_s) && *request.deadline_s > 0)) {
    c.fault("deadline_s", "must be finite and above 0");
  }
  if (!(request.speed_scale > 0 && request.speed_scale <= 1)) {
    c.fault("speed_scale", "must be in (0, 1]");
  } else if (request.speed_scale < bounds::kSlowest) {
    c.fault("speed_scale", "is below 0.001");
  }
  return std::move(c.faults);
}

std::vector<Fault> check(const PlanEvent& stage) {
  Checker c;
  c.finite("elapsed_s", stage.elapsed_s);
  std::visit([&c](const auto& payload) { checkPayload(c, payload); }, stage.payload);
  return std::move(c.faults);
}

std::vector<Fault> check(const DaemonStatus& status) {
  Checker c;
  c.name("version", status.version);
  const int state = static_cast<int>(status.state);
  if (state < 1 || state > static_cast<int>(DaemonState::kStopping)) {
    c.fault("state", "is not a state");
  }
  c.list("cells", status.cells, bounds::kCells, [&c](const std::string& at, const CellInfo& cell) {
    c.required(at + ".name", cell.name);
    c.names(at + ".tasks", cell.tasks, bounds::kCells);
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

const char* toString(DaemonState state) {
  switch (state) {
    case DaemonState::kUnspecified:
      return "unspecified";
    case DaemonState::kPreparing:
      return "preparing";
    case DaemonState::kReady:
      return "ready";
    case DaemonState::kStopping:
      return "stopping";
  }
  return "unspecified";
}

}  // namespace handover
