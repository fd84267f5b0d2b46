// SPDX-License-Identifier: Apache-2.0
#include "verify/state_obj.hpp"

#include "verify/checks.hpp"
#include "verify/motion.hpp"
#include "verify/unreadable.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace handover::verify {
namespace {

constexpr std::string_view kStart = "start";
constexpr std::string_view kEnd = "end";

/// Place of the stage; -1: none of that kind.
int stageOf(std::string_view kind) {
  for (int stage = 0; stage < kStages; ++stage) {
    if (kind == stageName(stage)) return stage;
  }
  return -1;
}

double timeOf(std::string_view kind, const Motion& motion) {
  if (kind == kStart) return 0.0;
  if (kind == kEnd) {
    return std::max(motion.stage(kGiverRetreat).end(), motion.stage(kReceiverRetreat).end());
  }
  return motion.stage(stageOf(kind)).end();
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
  return kind == kStart || kind == kEnd || stageOf(kind) >= 0;
}

std::string stateObj(std::string_view plan_text, const std::filesystem::path& root,
                     std::string_view kind) {
  Report faults;  // whether the plan is a good one is not asked here
  const Scene scene = loadScene(parsePlan(plan_text), root, faults);
  if (!checkStructure(scene, faults) || !checkHolds(scene, faults)) {
    throw Unreadable("/plan/stages", faults.violations.back().what);
  }
  const Motion motion(scene);
  const double time = timeOf(kind, motion);
  std::vector<std::vector<Pose>> X_WL;
  for (std::size_t robot = 0; robot < scene.robots.size(); ++robot) {
    X_WL.push_back(motion.linksAt(static_cast<int>(robot), time));
  }
  ObjWriter writer;
  for (const SceneBody& body : scene.bodies) {
    if (body.robot >= 0) {
      writer.add(body,
                 X_WL[static_cast<std::size_t>(body.robot)][static_cast<std::size_t>(body.link)]);
    } else if (body.object == scene.object) {
      writer.add(body, motion.objectAt(time));
    } else {
      writer.add(body, motion.otherObjectAt(body.object, time));
    }
  }
  return std::move(writer).text();
}

}  // namespace handover::verify
