// SPDX-License-Identifier: Apache-2.0
#include "settings/remarks.hpp"

#include "core/collision/gjk.hpp"
#include "core/decomposition/surface_bodies.hpp"
#include "core/grasp/finger_closing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace handover {
namespace {

using Eigen::Vector3d;

// What a task moves, what stands in a cell: larger or smaller ones are rather slips of a unit.
constexpr double kLargest = 20, kSmallest = 1e-3;  // [m]
/// The least edge of a thing over what a hand opens to: a chair is 4 of them, and has legs; a cup
/// in centimetres is 70.
constexpr double kFarTooWide = 20;
constexpr double kMostTurns = 4;

std::string text(const char* format, double value) {
  char out[48];
  std::snprintf(out, sizeof(out), format, value);
  return out;
}

std::string sizeText(const Vector3d& size) {
  const bool large = size.maxCoeff() >= 10;
  std::string out;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) out += " x ";
    out += text("%.4g", large ? size[axis] : 1e3 * size[axis]);
  }
  return out + (large ? " m" : " mm");
}

std::string volumeText(double volume) {
  if (volume >= 0.01) return text("%.3g m3", volume);
  return text(volume < 1e-4 ? "%.3g cm3" : "%.0f cm3", 1e6 * volume);
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Of shapes, and of the surfaces that some of them only approach.
Eigen::AlignedBox3d boxOf(const std::vector<Shape>& shapes, const DividedBodies& divided,
                          const Pose& X_WB) {
  std::vector<bool> exact(shapes.size(), true);
  Eigen::AlignedBox3d box;
  for (const DividedBody& body : divided) {
    std::fill_n(exact.begin() + body.first_shape, body.shape_count, false);
    for (const Vector3d& v : body.surface.vertices) box.extend(X_WB * v);
  }
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (!exact[i]) continue;
    const RoundedCore rounded = coreOf(shapes[i]);
    const Pose X_WS = X_WB * shapes[i].X_BS;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        const Vector3d along = sign * X_WS.linear().row(axis).transpose();
        box.extend(Vector3d(X_WS * supportPoint(rounded.core, along) +
                            sign * rounded.radius * Vector3d::Unit(axis)));
      }
    }
  }
  return box;
}

const DividedBodies& dividedOf(const std::shared_ptr<const DividedBodies>& divided) {
  static const DividedBodies kNone;
  return divided ? *divided : kNone;
}

double partsVolume(const std::vector<Shape>& shapes, const DividedBody& body) {
  double volume = 0;
  const auto first = shapes.begin() + body.first_shape;
  for (auto shape = first; shape != first + body.shape_count; ++shape) {
    const auto& convex = std::get<ConvexShape>(shape->geometry);
    volume += signedVolume({convex.vertices, convex.triangles});
  }
  return volume;
}

/// What a hand opens to; nothing for one without fingers, or without shapes.
double openingOrNone(const RobotModel& model, ArmId arm) {
  const HandId hand = model.arms[arm].hand;
  if (!hand.valid() || model.hands[hand].suction) return 0;
  try {
    return handOpening(model, arm);
  } catch (const std::invalid_argument&) {
    return 0;  // the grasps' fault to tell
  }
}

class ObjectRemarks {
 public:
  ObjectRemarks(const SceneObject& object, std::string path, Remarks& remarks)
      : object_(object),
        divided_(dividedOf(object.divided)),
        path_(std::move(path)),
        size_(boxOf(object.shapes, divided_, Pose::Identity()).sizes()),
        remarks_(remarks) {}

  void add() {
    addFacts();
    addOpenings();
    if (size_.maxCoeff() > kLargest || size_.maxCoeff() < kSmallest) {
      const bool large = size_.maxCoeff() > kLargest;
      warn("is " + sizeText(size_) + ": lengths are in metres; " +
           (large ? "written in millimetres, it needs a scale of [0.001, 0.001, 0.001]"
                  : "is its scale right?"));
    }
  }

  /// @param opening  the most of any hand [m]; 0: none has fingers.
  void addGraspable(double opening) {
    if (size_.maxCoeff() > kLargest || opening <= 0) return;
    if (size_.minCoeff() < kFarTooWide * opening) return;
    warn("is " + sizeText(size_) + ", and no hand opens to more than " +
         text("%.0f mm", 1e3 * opening) + ": is its unit right?");
  }

 private:
  void warn(const std::string& message) { remarks_.warnings.add(path_, message); }

  void addFacts() {
    std::string fact =
        sizeText(size_) + ", " + counted(object_.shapes.size(), "convex part", "convex parts");
    for (const DividedBody& body : divided_) {
      fact += "; " + counted(static_cast<std::size_t>(body.shape_count), "part", "parts") + " of " +
              volumeText(partsVolume(object_.shapes, body)) + " for ";
      fact += body.open_edges > 0 ? "an open surface"
                                  : "a body of " + volumeText(signedVolume(body.surface));
    }
    remarks_.facts.add(path_, fact);
  }

  void addOpenings() {
    std::size_t bodies = 0, edges = 0;
    for (const DividedBody& body : divided_) {
      if (body.open_edges == 0) continue;
      ++bodies;
      edges += static_cast<std::size_t>(body.open_edges);
    }
    if (bodies == 0) return;
    warn("its surface is open in " + counted(bodies, "body", "bodies") + " (" +
         counted(edges, "edge has", "edges have") +
         " not two faces): what it surrounds may count as outside");
  }

  const SceneObject& object_;
  const DividedBodies& divided_;
  std::string path_;
  Vector3d size_;
  Remarks& remarks_;
};

}  // namespace

void remarkOnShapes(const SceneObject& object, const std::string& path, Remarks& remarks) {
  ObjectRemarks(object, path, remarks).add();
}

void remarkOnObjects(const Scene& scene, const std::vector<SceneTask>& tasks, Remarks& remarks) {
  double opening = 0;
  for (const SceneRobot& robot : scene.robots) {
    for (const ArmId arm : IdRange<ArmId>(robot.model->arms.size())) {
      opening = std::max(opening, openingOrNone(*robot.model, arm));
    }
  }
  for (const SceneObject& object : scene.objects) {
    ObjectRemarks of_object(object, "objects." + object.name, remarks);
    of_object.add();
    const bool moved = std::any_of(tasks.begin(), tasks.end(), [&](const SceneTask& task) {
      return task.object == object.name;
    });
    if (moved) of_object.addGraspable(opening);
  }
}

void remarkOnRobot(const RobotModel& model, const RobotVector& q_start, const std::string& path,
                   Remarks& remarks) {
  std::vector<Pose> X_BL;
  linkPoses(model, Pose::Identity(), q_start, X_BL);
  Eigen::AlignedBox3d box;
  std::size_t parts = 0, divided = 0, open = 0;
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    const Link& link = model.links[l];
    if (link.collision.empty()) continue;
    box.extend(boxOf(link.collision, dividedOf(link.divided), X_BL[l]));
    parts += link.collision.size();
    for (const DividedBody& body : dividedOf(link.divided)) {
      ++divided;
      open += body.open_edges > 0 ? 1 : 0;
    }
  }
  if (parts > 0) {
    std::string fact = sizeText(box.sizes()) + " as it starts, " +
                       counted(model.links.size(), "link", "links") + ", " +
                       counted(parts, "convex part", "convex parts");
    if (divided > 0) {
      fact += ", some of them for " + counted(divided, "body", "bodies") +
              " that are not convex, " + std::to_string(open) + " of these open";
    }
    remarks.facts.add(path, fact);
  }
  for (const Joint& joint : model.joints) {
    if (joint.type != JointType::kRevolute || joint.mimic || joint.continuous) continue;
    if (joint.upper - joint.lower <= kMostTurns * 2 * M_PI) continue;
    remarks.warnings.add(
        path, "joint '" + joint.name + "' may turn from " + text("%.9g", joint.lower) + " to " +
                  text("%.9g rad", joint.upper) + ", more than 4 times round: degrees?");
  }
}

}  // namespace handover
