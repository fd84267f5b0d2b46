// SPDX-License-Identifier: Apache-2.0
#include "core/collision/state_checker.hpp"

#include "core/collision/scene_data.hpp"

#include <algorithm>
#include <stdexcept>

namespace handover {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(std::string("StateChecker: ") + what);
}

bool inRange(int index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

}  // namespace

StateCheckerSetup::StateCheckerSetup(const CollisionScene& scene, int moving_robot,
                                     std::vector<int> moving_dofs)
    : robot(moving_robot), dofs(std::move(moving_dofs)), allowed(scene.bodies()) {
  for (const SceneRobot& it : scene.data().robots) q.push_back(it.q_start);
  for (const ScenePlacement& it : scene.data().objects) X_WO.push_back(it.X_WO);
}

StateChecker::StateChecker(CollisionWorld& world, StateCheckerSetup setup)
    : world_(&world), setup_(std::move(setup)) {
  checkSetup();
  compile();
}

void StateChecker::checkSetup() const {
  const CollisionScene::Data& scene = world_->scene().data();
  require(inRange(setup_.robot, scene.robots.size()), "no such robot");
  require(setup_.q.size() == scene.robots.size(), "one posture per robot");
  require(setup_.X_WO.size() == scene.objects.size(), "one pose per object");
  require(setup_.allowed.bodies() == world_->scene().bodies(), "allowed pairs of another scene");
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    require(setup_.q[r].size() == scene.robots[r].model->dofs(), "a posture's size is wrong");
  }
  const RobotModel& model = *scene.robots[static_cast<std::size_t>(setup_.robot)].model;
  for (int dof : setup_.dofs) require(inRange(dof, model.dof_joints.size()), "no such dof");
  if (!setup_.held) return;
  require(inRange(setup_.held->object, scene.objects.size()), "no such object to hold");
  require(inRange(setup_.held->link, model.links.size()), "no such link to hold with");
}

// Links that move as one have the same group: that of the last moving joint above them. Links that
// do not move have none.
std::vector<int> StateChecker::rigidGroups() const {
  const RobotModel& model =
      *world_->scene().data().robots[static_cast<std::size_t>(setup_.robot)].model;
  std::vector<int> group(model.links.size(), -1);
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    const int parent_joint = model.links[l].parent_joint;
    if (parent_joint < 0) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(parent_joint)];
    const bool moves = joint.dof >= 0 && std::find(setup_.dofs.begin(), setup_.dofs.end(),
                                                   joint.dof) != setup_.dofs.end();
    group[l] = moves ? static_cast<int>(l) : group[static_cast<std::size_t>(joint.parent_link)];
  }
  return group;
}

void StateChecker::compile() {
  const CollisionScene& scene = world_->scene();
  const std::vector<int> link_group = rigidGroups();
  std::vector<int> group(static_cast<std::size_t>(scene.bodies()), -1);
  const auto carry = [&](int object, int link, const Pose& X_LO) {
    if (link_group[static_cast<std::size_t>(link)] < 0) return;
    const BodyId body = scene.objectBody(object);
    carried_.push_back({body, link, X_LO});
    moving_.push_back(body);
    group[static_cast<std::size_t>(body)] = link_group[static_cast<std::size_t>(link)];
  };
  if (setup_.held) carry(setup_.held->object, setup_.held->link, setup_.held->X_LO);
  const std::vector<ScenePlacement>& objects = scene.data().objects;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const std::optional<Attachment>& attached = objects[o].attached_to;
    if (!attached || attached->robot != setup_.robot) continue;
    if (setup_.held && setup_.held->object == static_cast<int>(o)) continue;
    carry(static_cast<int>(o), attached->link, attached->X_LO);
  }
  // From the tool inwards: what is farthest out touches most often.
  for (int l = static_cast<int>(link_group.size()) - 1; l >= 0; --l) {
    if (link_group[static_cast<std::size_t>(l)] < 0) continue;
    links_.push_back(l);
    const BodyId body = scene.linkBody(setup_.robot, l);
    if (body < 0) continue;
    link_bodies_.push_back({body, l});
    moving_.push_back(body);
    group[static_cast<std::size_t>(body)] = link_group[static_cast<std::size_t>(l)];
  }
  std::reverse(links_.begin(), links_.end());
  pairs_ = world_->makePairs(moving_, setup_.allowed, group);
}

void StateChecker::activate() {
  const CollisionScene::Data& scene = world_->scene().data();
  for (std::size_t o = 0; o < setup_.X_WO.size(); ++o) {
    world_->setPose(scene.object_bodies[o], setup_.X_WO[o]);
  }
  // The moving robot last: its link poses stay.
  const int robots = static_cast<int>(scene.robots.size());
  for (int i = 1; i <= robots; ++i) {
    const auto r = static_cast<std::size_t>((setup_.robot + i) % robots);
    handover::linkPoses(*scene.robots[r].model, scene.robots[r].X_WB, setup_.q[r], X_WL_);
    world_->setRobot(static_cast<int>(r), X_WL_);
  }
  // Held ones again: the scene may have them attached elsewhere, and a link that stands still holds
  // too.
  if (setup_.held) {
    const Pose& X_WL = X_WL_[static_cast<std::size_t>(setup_.held->link)];
    world_->setPose(world_->scene().objectBody(setup_.held->object), X_WL * setup_.held->X_LO);
  }
  q_ = setup_.q[static_cast<std::size_t>(setup_.robot)];
  seen_changes_ = world_->changes();
  stale_ = false;
}

void StateChecker::place(const Eigen::Ref<const Eigen::VectorXd>& q) {
  require(q.size() == static_cast<Eigen::Index>(setup_.dofs.size()), "one position per moving dof");
  require(q.allFinite(), "positions must be finite");
  if (stale_ || seen_changes_ != world_->changes()) activate();
  for (std::size_t i = 0; i < setup_.dofs.size(); ++i) {
    q_[setup_.dofs[i]] = q[static_cast<Eigen::Index>(i)];
  }
  const SceneRobot& robot = world_->scene().data().robots[static_cast<std::size_t>(setup_.robot)];
  linkPosesOf(*robot.model, q_, links_, X_WL_);
  for (const MovingLink& it : link_bodies_) {
    world_->setPose(it.body, X_WL_[static_cast<std::size_t>(it.link)]);
  }
  for (const CarriedObject& it : carried_) {
    world_->setPose(it.body, X_WL_[static_cast<std::size_t>(it.link)] * it.X_LO);
  }
  seen_changes_ = world_->changes();
}

bool StateChecker::valid(const Eigen::Ref<const Eigen::VectorXd>& q) {
  place(q);
  return world_->isFree(pairs_);
}

std::optional<BodyContact> StateChecker::hit(const Eigen::Ref<const Eigen::VectorXd>& q) {
  place(q);
  BodyContact contact;
  if (world_->isFree(pairs_, &contact)) return std::nullopt;
  return contact;
}

std::vector<BodyContact> StateChecker::contacts(const Eigen::Ref<const Eigen::VectorXd>& q) {
  place(q);
  return world_->contacts(pairs_);
}

void StateChecker::setPosture(int robot, const RobotVector& q) {
  RobotVector& posture = setup_.q.at(static_cast<std::size_t>(robot));
  require(q.size() == posture.size(), "a posture's size is wrong");
  posture = q;
  stale_ = true;
}

void StateChecker::setObject(int object, const Pose& X_WO) {
  setup_.X_WO.at(static_cast<std::size_t>(object)) = X_WO;
  stale_ = true;
}

void StateChecker::setHold(const Pose& X_LO) {
  require(setup_.held.has_value(), "nothing is held");
  setup_.held->X_LO = X_LO;
  const BodyId body = world_->scene().objectBody(setup_.held->object);
  for (CarriedObject& it : carried_) {
    if (it.body == body) it.X_LO = X_LO;
  }
  stale_ = true;
}

}  // namespace handover
