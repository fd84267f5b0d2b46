// SPDX-License-Identifier: Apache-2.0
#include "verify/state_obj.hpp"

#include "verify/checks.hpp"
#include "verify/motion.hpp"
#include "verify/unreadable.hpp"

#include <charconv>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace handover::verify {
namespace {

constexpr std::string_view kStart = "start";
constexpr std::string_view kEnd = "end";

/// "7" is a stage's index, "grasp.1" an action and its holder.
struct StageNamed {
  std::string action;  ///< empty: by index
  int number = 0;
};

std::optional<StageNamed> stageNamed(std::string_view kind) {
  StageNamed named;
  const auto dot = kind.find('.');
  if (dot != std::string_view::npos) {
    static const std::set<std::string_view> kActions = {
        "reach", "approach", "grasp", "lift", "carry", "place", "release", "retreat", "home"};
    named.action = kind.substr(0, dot);
    if (!kActions.count(named.action)) return std::nullopt;
    kind.remove_prefix(dot + 1);
  }
  const char* end = kind.data() + kind.size();
  const auto [next, error] = std::from_chars(kind.data(), end, named.number);
  if (error != std::errc() || next != end || named.number < 0) return std::nullopt;
  return named;
}

double timeOf(std::string_view kind, const Motion& motion) {
  if (kind == kStart) return 0.0;
  if (kind == kEnd) return motion.end();
  const StageNamed named = stageNamed(kind).value();
  const Scene& scene = motion.scene();
  for (int s = 0; s < scene.stageCount(); ++s) {
    const PlanStage& stage = scene.stage(s);
    const bool is_it = named.action.empty()
                           ? s == named.number
                           : stage.action == named.action && stage.holder == named.number;
    if (is_it) return motion.end(s);
  }
  throw Unreadable("/plan/stages", "no stage " + std::string(kind));
}

/// Appends bodies to the text; corners count through the whole file, from 1.
class ObjWriter {
 public:
  void add(const SceneBody& body, const Pose& X_WBody) {
    text_ += "o " + body.name + "\n";
    for (const Shell& shell : body.body.shells()) add(shell.mesh, X_WBody);
  }

  std::string text() && { return std::move(text_); }

 private:
  void add(const Mesh& mesh, const Pose& X_WBody) {
    char line[96];
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      const Eigen::Vector3d p = X_WBody * vertex;
      std::snprintf(line, sizeof line, "v %.6f %.6f %.6f\n", p.x(), p.y(), p.z());
      text_ += line;
    }
    for (const Triangle& t : mesh.triangles) {
      text_ += "f";
      for (const int corner : t) text_ += " " + std::to_string(first_ + corner);
      text_ += "\n";
    }
    first_ += static_cast<int>(mesh.vertices.size());
  }

  std::string text_;
  int first_ = 1;
};

}  // namespace

bool namesState(std::string_view kind) {
  return kind == kStart || kind == kEnd || stageNamed(kind).has_value();
}

std::string stateObj(std::string_view plan_text, const std::filesystem::path& root,
                     std::string_view kind) {
  Report faults;  // whether the plan is a good one is not asked here
  const Scene scene = loadScene(parsePlan(plan_text), root, faults);
  if (!checkStructure(scene, faults)) {
    throw Unreadable("/plan/stages", faults.violations.back().what);
  }
  const Curves curves(scene);
  const Task task = makeTask(scene);
  const Motion motion(curves, task, plannedStarts(scene));
  const double time = timeOf(kind, motion);
  ObjWriter writer;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    writer.add(scene.bodies[b], motion.bodyAt(static_cast<int>(b), time));
  }
  return std::move(writer).text();
}

}  // namespace handover::verify
