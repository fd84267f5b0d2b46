// SPDX-License-Identifier: Apache-2.0
#include "grasp_checker.hpp"

#include <fcl/fcl.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace handover {
namespace {

using Tree = fcl::BVHModel<fcl::OBBRSSd>;
using Eigen::Vector3d;
using Eigen::VectorXd;

void addShape(Tree& tree, const Shape& shape) {
  std::vector<Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
  const auto take = [&](const auto& primitive, auto... detail) {
    Tree part;
    fcl::generateBVHModel(part, primitive, fcl::Transform3d(shape.X_BS.matrix()), detail...);
    vertices.assign(part.vertices, part.vertices + part.num_vertices);
    triangles.assign(part.tri_indices, part.tri_indices + part.num_tris);
  };
  if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) {
    take(fcl::Boxd(box->size.x(), box->size.y(), box->size.z()));
  } else if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) {
    take(fcl::Sphered(sphere->radius), 96u, 96u);
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
    take(fcl::Cylinderd(cylinder->radius, cylinder->length), 128u, 2u);
  } else {
    const auto& convex = std::get<ConvexShape>(shape.geometry);
    for (const Vector3d& v : convex.vertices) vertices.push_back(shape.X_BS * v);
    for (const auto& t : convex.triangles) {
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    }
  }
  tree.addSubModel(vertices, triangles);
}

std::shared_ptr<Tree> treeOf(const std::vector<Shape>& shapes) {
  if (shapes.empty()) return nullptr;
  auto tree = std::make_shared<Tree>();
  tree->beginModel();
  for (const Shape& shape : shapes) addShape(*tree, shape);
  tree->endModel();
  return tree;
}

struct Nearest {
  double distance = 0;
  Vector3d on_a, on_b;
};

Nearest nearest(const Tree& a, const Pose& X_a, const Tree& b, const Pose& X_b) {
  const fcl::CollisionObjectd body_a(
      std::const_pointer_cast<Tree>(std::shared_ptr<const Tree>(&a, [](auto*) {})),
      fcl::Transform3d(X_a.matrix()));
  const fcl::CollisionObjectd body_b(
      std::const_pointer_cast<Tree>(std::shared_ptr<const Tree>(&b, [](auto*) {})),
      fcl::Transform3d(X_b.matrix()));
  fcl::DistanceRequestd request(true);
  fcl::DistanceResultd result;
  fcl::distance(&body_a, &body_b, request, result);
  return {std::max(0.0, result.min_distance), result.nearest_points[0], result.nearest_points[1]};
}

}  // namespace

struct GraspChecker::Data {
  const RobotModel* model = nullptr;
  ArmId arm{0};
  std::shared_ptr<Tree> object;
  std::vector<std::shared_ptr<Tree>> links;
  std::vector<LinkId> hand_links;  // rigidly beyond the wrist, and the fingers
  std::vector<bool> is_finger;
  std::vector<std::pair<LinkId, LinkId>> self_pairs;  // of the hand that must not touch

  /// Least distance of two parts of the hand that must not touch.
  double selfClearance(const VectorXd& q) const {
    const auto X = pose(Pose::Identity(), q);
    double least = 1e9;
    for (const auto& [a, b] : self_pairs) {
      least = std::min(least, nearest(*links[a], X[a], *links[b], X[b]).distance);
    }
    return least;
  }

  /// Link poses in O with the tool at X_OT.
  std::vector<Pose> pose(const Pose& X_OT, const VectorXd& q_hand) const {
    const Arm& a = model->arms[arm];
    const Hand& hand = model->hands[a.hand];
    RobotVector q = RobotVector::Zero(model->dofs());
    for (std::size_t i = 0; i < hand.dofs.size(); ++i)
      q[hand.dofs[i].value()] = q_hand[static_cast<Eigen::Index>(i)];
    std::vector<Pose> X;
    linkPoses(*model, Pose::Identity(), q, X);
    const Pose X_OW = X_OT * X[a.tool_link].inverse();
    for (Pose& link : X) link = X_OW * link;
    return X;
  }

  /// Distance of the whole hand to the object.
  double clearance(const Pose& X_OT, const VectorXd& q) const {
    const auto X = pose(X_OT, q);
    double least = 1e9;
    for (const LinkId link : hand_links) {
      const std::size_t at = link;
      if (links[at])
        least = std::min(least, nearest(*links[at], X[at], *object, Pose::Identity()).distance);
    }
    return least;
  }
};

GraspChecker::GraspChecker(const SceneObject& object, const RobotModel& model, ArmId arm)
    : data_(std::make_unique<Data>()) {
  data_->model = &model;
  data_->arm = arm;
  data_->object = treeOf(object.shapes);
  for (const Link& link : model.links) data_->links.push_back(treeOf(link.collision));
  const Arm& a = model.arms[arm];
  data_->hand_links = model.linksMovedBy({a.dofs.back()});
  data_->is_finger.assign(model.links.size(), false);
  for (const LinkId link : model.hands[a.hand].finger_links) {
    data_->is_finger[link] = true;
  }
  for (const LinkId i : data_->hand_links) {
    for (const LinkId j : data_->hand_links) {
      if (i >= j || !data_->links[i] || !data_->links[j]) continue;
      const auto disabled = model.disabled_pairs.find({i, j});
      const bool standing = disabled != model.disabled_pairs.end() && disabled->second != "Never";
      if (!standing && !model.adjacent(i, j)) data_->self_pairs.emplace_back(i, j);
    }
  }
}

GraspChecker::~GraspChecker() = default;

std::string GraspChecker::faultOf(const Grasp& grasp) const {
  std::ostringstream fault;
  const Arm& arm = data_->model->arms[data_->arm];
  for (int step = 0; step <= 10; ++step) {
    const Eigen::Translation3d back(Vector3d(-0.01 * step * arm.approach_axis));
    const double clear = data_->clearance(grasp.X_OT * back, grasp.open);
    if (clear < 0.002)
      fault << "open hand " << clear << " m off the object, " << step << " cm back; ";
  }
  for (int step = 1; step <= 10; ++step) {
    const VectorXd q = grasp.closed + 0.1 * step * (grasp.open - grasp.closed);
    if (data_->clearance(grasp.X_OT, q) <= 0) fault << "fingers inside the object while closing; ";
  }
  const auto X = data_->pose(grasp.X_OT, grasp.closed);
  if (data_->selfClearance(grasp.closed) < 0.002) fault << "closed hand touches itself; ";
  if (data_->selfClearance(grasp.open) < 0.002) fault << "open hand touches itself; ";
  std::vector<Vector3d> normals;
  for (const LinkId link : data_->hand_links) {
    const auto at = static_cast<std::size_t>(link);
    if (!data_->links[at]) continue;
    const Nearest near = nearest(*data_->links[at], X[at], *data_->object, Pose::Identity());
    const std::string& name = data_->model->links[at].name;
    if (near.distance <= 5e-5) fault << name << " inside the object; ";
    if (!data_->is_finger[at] && near.distance < 0.002) fault << name << " touches the object; ";
    if (data_->is_finger[at] && near.distance < 0.002)
      normals.push_back((near.on_a - near.on_b).normalized());
  }
  double opposing = 0;
  for (const Vector3d& a : normals) {
    for (const Vector3d& b : normals)
      opposing = std::max(opposing, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
  }
  if (opposing <= 2.0 * M_PI / 3.0)
    fault << "widest angle of contact normals " << opposing * 180 / M_PI << " deg; ";
  return fault.str();
}

double GraspChecker::distance(const GraspChecker& a, const Grasp& grasp_a, const VectorXd& q_a,
                              const GraspChecker& b, const Grasp& grasp_b, const VectorXd& q_b) {
  const auto X_a = a.data_->pose(grasp_a.X_OT, q_a);
  const auto X_b = b.data_->pose(grasp_b.X_OT, q_b);
  double least = 1e9;
  for (const LinkId i : a.data_->hand_links) {
    for (const LinkId j : b.data_->hand_links) {
      const auto& tree_a = a.data_->links[i];
      const auto& tree_b = b.data_->links[j];
      if (!tree_a || !tree_b) continue;
      least = std::min(least, nearest(*tree_a, X_a[i], *tree_b, X_b[j]).distance);
      if (least <= 0) return 0;
    }
  }
  return least;
}

void GraspChecker::writeObj(const Grasp& grasp, const VectorXd& q, const std::string& file) const {
  std::ofstream out(file);
  int base = 1;
  const auto add = [&](const Tree& tree, const Pose& X, const std::string& name) {
    out << "o " << name << "\n";
    for (int i = 0; i < tree.num_vertices; ++i)
      out << "v " << (X * tree.vertices[i]).transpose() << "\n";
    for (int i = 0; i < tree.num_tris; ++i) {
      const auto& t = tree.tri_indices[i];
      out << "f " << base + static_cast<int>(t[0]) << " " << base + static_cast<int>(t[1]) << " "
          << base + static_cast<int>(t[2]) << "\n";
    }
    base += tree.num_vertices;
  };
  add(*data_->object, Pose::Identity(), "object");
  const auto X = data_->pose(grasp.X_OT, q);
  for (const LinkId link : data_->hand_links) {
    const auto at = static_cast<std::size_t>(link);
    if (data_->links[at]) add(*data_->links[at], X[at], data_->model->links[at].name);
  }
}

}  // namespace handover
