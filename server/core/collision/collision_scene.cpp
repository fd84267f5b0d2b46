// SPDX-License-Identifier: Apache-2.0
#include "core/collision/collision_scene.hpp"

#include "core/collision/scene_data.hpp"

#include <Eigen/Eigenvalues>

#include <stdexcept>

namespace handover {
namespace {

struct Box {
  Pose X_SBox = Pose::Identity();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
};

Box boxAlong(const Eigen::Matrix3d& R_SBox, const std::vector<Eigen::Vector3d>& vertices) {
  Eigen::Vector3d lower = R_SBox.transpose() * vertices.front();
  Eigen::Vector3d upper = lower;
  for (const Eigen::Vector3d& v : vertices) {
    lower = lower.cwiseMin(R_SBox.transpose() * v);
    upper = upper.cwiseMax(R_SBox.transpose() * v);
  }
  Box box;
  box.X_SBox.linear() = R_SBox;
  box.X_SBox.translation() = R_SBox * (0.5 * (lower + upper));
  box.half = 0.5 * (upper - lower);
  return box;
}

// The smaller of the box along the shape's own axes and the one along its principal axes.
Box hullBox(const std::vector<Eigen::Vector3d>& vertices) {
  const Box own = boxAlong(Eigen::Matrix3d::Identity(), vertices);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : vertices) mean += v / static_cast<double>(vertices.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& v : vertices) covariance += (v - mean) * (v - mean).transpose();
  Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  const Box principal = boxAlong(axes, vertices);
  return principal.half.prod() < own.half.prod() ? principal : own;
}

struct BoxOf {
  Box operator()(const BoxShape& box) const { return {Pose::Identity(), 0.5 * box.size}; }

  Box operator()(const SphereShape& sphere) const {
    return {Pose::Identity(), Eigen::Vector3d::Constant(sphere.radius)};
  }

  Box operator()(const CylinderShape& c) const {
    return {Pose::Identity(), Eigen::Vector3d(c.radius, c.radius, 0.5 * c.length)};
  }

  Box operator()(const ConvexShape& convex) const { return hullBox(convex.vertices); }
};

SceneShape sceneShape(const Shape& shape) {
  if (!shape.X_BS.matrix().allFinite()) throw std::invalid_argument("a shape's pose is not finite");
  NarrowShape narrow(shape);
  const Box box = std::visit(BoxOf{}, shape.geometry);
  return {std::move(narrow), shape.X_BS, shape.X_BS * box.X_SBox,
          box.half + Eigen::Vector3d::Constant(kCollisionMargin)};
}

void addBody(CollisionScene::Data& data, std::string name, BodyOwner owner,
             const std::vector<Shape>& shapes) {
  data.names.push_back(std::move(name));
  data.owners.push_back(owner);
  for (const Shape& shape : shapes) data.shapes.push_back(sceneShape(shape));
  data.first_shape.push_back(static_cast<int>(data.shapes.size()));
}

void addRobotBodies(CollisionScene::Data& data, const SceneRobot& robot, RobotId index) {
  const RobotModel& model = *robot.model;
  std::vector<BodyId> bodies(model.links.size());
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    if (model.links[l].collision.empty()) continue;
    bodies[l] = BodyId(data.names.size());
    addBody(data, robot.name + "/" + model.links[l].name, {index, LinkId(l), {}},
            model.links[l].collision);
  }
  data.link_bodies.push_back(std::move(bodies));
}

BodyId findObjectBody(const CollisionScene::Data& data, const Scene& scene, const std::string& name,
                      const std::string& asked_by) {
  const ObjectId object = scene.findObject(name);
  if (!object.valid())
    throw std::invalid_argument(asked_by + " rests on '" + name + "', no object");
  return data.object_bodies[object];
}

void addLinkPairs(CollisionScene::Data& data, const RobotModel& model,
                  const std::vector<BodyId>& bodies) {
  const IdRange<LinkId> links(bodies.size());
  for (const LinkId a : links) {
    for (const LinkId b : links) {
      if (!(a < b) || !bodies[a].valid() || !bodies[b].valid()) continue;
      if (model.adjacent(a, b)) data.standing.insert(bodies[a], bodies[b]);
    }
  }
  for (const auto& [pair, reason] : model.disabled_pairs) {
    if (reason != "Adjacent" && reason != "Always") continue;
    const BodyId a = bodies[pair.first], b = bodies[pair.second];
    if (a.valid() && b.valid()) data.standing.insert(a, b);
  }
}

void addRestingPairs(CollisionScene::Data& data, const Scene& scene) {
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    for (const auto& [link, name] : scene.robots[r].resting) {
      const std::string who = scene.robots[r].name;
      const BodyId other = findObjectBody(data, scene, name, who);
      const BodyId body = data.link_bodies[r].at(link);
      if (body.valid()) data.standing.insert(body, other);
    }
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    for (const std::string& name : scene.objects[o].resting) {
      const BodyId other = findObjectBody(data, scene, name, scene.objects[o].name);
      data.standing.insert(data.object_bodies[o], other);
    }
  }
}

void addAttachmentPairs(CollisionScene::Data& data, const Scene& scene) {
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const std::optional<Attachment>& attached = scene.objects[o].attached_to;
    if (!attached) continue;
    std::vector<LinkId> links = attached->touch_links;
    links.push_back(attached->link);
    for (const LinkId link : links) {
      const BodyId body = data.link_bodies.at(attached->robot).at(link);
      if (body.valid()) data.standing.insert(body, data.object_bodies[o]);
    }
  }
}

}  // namespace

void BodyPairs::insert(const std::vector<BodyId>& as, const std::vector<BodyId>& bs) {
  for (BodyId a : as) {
    for (BodyId b : bs) {
      if (a.valid() && b.valid()) insert(a, b);
    }
  }
}

CollisionScene::CollisionScene(const Scene& scene) {
  auto data = std::make_unique<Data>();
  data->robots = scene.robots;
  data->first_shape.push_back(0);
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    addRobotBodies(*data, scene.robots[r], RobotId(r));
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    data->object_bodies.push_back(BodyId(data->names.size()));
    data->objects.push_back({object.X_WO, object.attached_to});
    addBody(*data, object.name, {{}, {}, ObjectId(o)}, object.shapes);
  }
  data->standing = BodyPairs(static_cast<int>(data->names.size()));
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    addLinkPairs(*data, *scene.robots[r].model, data->link_bodies[r]);
  }
  addRestingPairs(*data, scene);
  addAttachmentPairs(*data, scene);
  data_ = std::move(data);
}

CollisionScene::~CollisionScene() = default;

int CollisionScene::bodies() const { return static_cast<int>(data_->names.size()); }

const std::string& CollisionScene::name(BodyId body) const { return data_->names.at(body); }

BodyId CollisionScene::linkBody(RobotId robot, LinkId link) const {
  return data_->link_bodies.at(robot).at(link);
}

std::vector<BodyId> CollisionScene::linkBodies(RobotId robot,
                                               const std::vector<LinkId>& links) const {
  std::vector<BodyId> bodies;
  for (const LinkId link : links) {
    const BodyId body = linkBody(robot, link);
    if (body.valid()) bodies.push_back(body);
  }
  return bodies;
}

BodyId CollisionScene::objectBody(ObjectId object) const { return data_->object_bodies.at(object); }

RobotId CollisionScene::robotOf(BodyId body) const { return data_->owners.at(body).robot; }

const BodyPairs& CollisionScene::standingPairs() const { return data_->standing; }

}  // namespace handover
