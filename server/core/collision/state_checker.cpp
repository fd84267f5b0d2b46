// SPDX-License-Identifier: Apache-2.0
#include "core/collision/state_checker.hpp"

#include "core/collision/moving_balls.hpp"
#include "core/collision/scene_data.hpp"

#include <algorithm>
#include <stdexcept>

namespace handover {
namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(std::string("StateChecker: ") + what);
}

template <class Tag>
bool inRange(Id<Tag> id, std::size_t size) {
  return id.valid() && std::size_t{id} < size;
}

const RobotModel& modelOf(const CollisionWorld& world, RobotId robot) {
  return *world.scene().data().robots[robot].model;
}

StateCheckerSetup checked(const CollisionWorld& world, StateCheckerSetup setup) {
  const CollisionScene::Data& scene = world.scene().data();
  require(inRange(setup.robot, scene.robots.size()), "no such robot");
  require(setup.q.size() == scene.robots.size(), "one posture per robot");
  require(setup.X_WO.size() == scene.objects.size(), "one pose per object");
  require(setup.allowed.bodies() == world.scene().bodies(), "allowed pairs of another scene");
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    require(setup.q[r].size() == scene.robots[r].model->dofs(), "a posture's size is wrong");
  }
  const RobotModel& model = modelOf(world, setup.robot);
  for (const DofId dof : setup.dofs) require(inRange(dof, model.dof_joints.size()), "no such dof");
  require(setup.tool_link.value() < static_cast<int>(model.links.size()), "no such tool link");
  require(!setup.tool_link.valid() || RigidGroups(model, setup.dofs).groupOf(setup.tool_link) >= 0,
          "the tool link does not move");
  if (!setup.held) return setup;
  require(inRange(setup.held->object, scene.objects.size()), "no such object to hold");
  require(inRange(setup.held->link, model.links.size()), "no such link to hold with");
  return setup;
}

}  // namespace

StateCheckerSetup::StateCheckerSetup(const CollisionScene& scene, RobotId moving_robot,
                                     std::vector<DofId> moving_dofs)
    : robot(moving_robot),
      dofs(std::move(moving_dofs)),
      allowed(scene.bodies()),
      close(scene.bodies()) {
  for (const SceneRobot& it : scene.data().robots) q.push_back(it.q_start);
  for (const ScenePlacement& it : scene.data().objects) X_WO.push_back(it.X_WO);
}

StateChecker::StateChecker(CollisionWorld& world, StateCheckerSetup setup)
    : world_(&world), setup_(checked(world, std::move(setup))), groups_(model(), setup_.dofs) {
  compile();
}

const RobotModel& StateChecker::model() const { return modelOf(*world_, setup_.robot); }

void StateChecker::compile() {
  const CollisionScene& scene = world_->scene();
  moving_index_.assign(static_cast<std::size_t>(scene.bodies()), -1);
  std::vector<int> body_groups(static_cast<std::size_t>(scene.bodies()), -1);
  const auto mount = [&](BodyId body, LinkId link, const Pose& X_LB) {
    if (!body.valid() || groups_.groupOf(link) < 0) return;
    moving_index_[body] = static_cast<int>(moving_.size());
    body_groups[body] = groups_.groupOf(link);
    moving_.push_back(body);
    mounts_.push_back({link, X_LB});
  };
  if (setup_.held) {
    mount(scene.objectBody(setup_.held->object), setup_.held->link, setup_.held->X_LO);
  }
  const std::vector<ScenePlacement>& objects = scene.data().objects;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const std::optional<Attachment>& attached = objects[o].attached_to;
    if (!attached || attached->robot != setup_.robot) continue;
    if (setup_.held && setup_.held->object == ObjectId(o)) continue;
    mount(scene.objectBody(ObjectId(o)), attached->link, attached->X_LO);
  }
  // From the tool inwards: what is farthest out touches most often.
  for (int l = static_cast<int>(model().links.size()) - 1; l >= 0; --l) {
    const LinkId link(l);
    mount(scene.linkBody(setup_.robot, link), link, Pose::Identity());
  }
  pairs_ = world_->makePairs(moving_, setup_.allowed, body_groups);
  if (setup_.tool_link.valid()) divide();
  divideByClearance();
}

void StateChecker::divideByClearance() {
  std::vector<std::pair<BodyId, BodyId>> close, wide;
  for (const auto& pair : pairs_.pairs()) {
    (setup_.close.contains(pair.first, pair.second) ? close : wide).push_back(pair);
  }
  close_pairs_ = PairList(std::move(close));
  wide_pairs_ = PairList(std::move(wide));
}

void StateChecker::divide() {
  const int tool = groups_.groupOf(setup_.tool_link);
  const auto index = [&](BodyId body) { return moving_index_[body]; };
  const auto withTool = [&](BodyId body) {
    return index(body) >= 0 &&
           groups_.groupOf(mounts_[static_cast<std::size_t>(index(body))].link) == tool;
  };
  const auto add = [&](Part& part, PairList::Row row, std::uint64_t movers) {
    row.movers = movers;
    if (movers != 0) part.rows.push_back(row);
  };
  for (const PairList::Row& row : pairs_.rows()) {
    std::uint64_t tools = 0;
    pairs_.forEachMover(row, [&](BodyId mover, std::uint64_t bit) {
      if (withTool(mover) || withTool(row.other)) tools |= bit;
    });
    add(index(row.other) < 0 ? tool_with_still_ : tool_with_arm_, row, tools);
    add(arm_with_all_, row, row.movers & ~tools);
  }
  for (Part* part : {&tool_with_still_, &tool_with_arm_, &arm_with_all_}) {
    std::vector<bool> used(moving_.size());
    for (const PairList::Row& row : part->rows) {
      if (index(row.other) >= 0) used[static_cast<std::size_t>(index(row.other))] = true;
      pairs_.forEachMover(row, [&](BodyId mover, std::uint64_t) {
        used[static_cast<std::size_t>(index(mover))] = true;
      });
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i]) part->bodies.push_back(i);
    }
  }
}

void StateChecker::activate() {
  const CollisionScene::Data& scene = world_->scene().data();
  for (std::size_t o = 0; o < setup_.X_WO.size(); ++o) {
    world_->setPose(scene.object_bodies[o], setup_.X_WO[o]);
  }
  // The moving robot last: its link poses stay.
  const int robots = static_cast<int>(scene.robots.size());
  for (int i = 1; i <= robots; ++i) {
    const auto r = static_cast<std::size_t>((setup_.robot.value() + i) % robots);
    linkPoses(*scene.robots[r].model, scene.robots[r].X_WB, setup_.q[r], X_WL_);
    world_->setRobot(RobotId(r), X_WL_);
  }
  // Held ones again: the scene may have them attached elsewhere, and a link that stands still holds
  // too.
  if (setup_.held) {
    const Pose& X_WL = X_WL_[setup_.held->link];
    world_->setPose(world_->scene().objectBody(setup_.held->object), X_WL * setup_.held->X_LO);
  }
  if (!mounted_) mountBodies();
  seen_changes_ = world_->changes();
  stale_ = false;
}

void StateChecker::mountBodies() {
  groups_.setPosture(model(), X_WL_);
  moving_bodies_.resize(moving_.size());
  for (std::size_t i = 0; i < moving_.size(); ++i) mountBody(i);
  if (setup_.tool_link.valid()) {
    const LinkId link = groups_.linkOf(groups_.groupOf(setup_.tool_link));
    X_GTool_ = X_WL_[link].inverse() * X_WL_[setup_.tool_link];
  }
  mounted_ = true;
  measured_ = false;
}

void StateChecker::mountBody(std::size_t i) {
  MovingBody& body = moving_bodies_[i];
  body.body = moving_[i];
  body.group = groups_.groupOf(mounts_[i].link);
  const Pose& X_WL = X_WL_[mounts_[i].link];
  const Pose& X_WG = X_WL_[groups_.linkOf(body.group)];
  body.X_GB = X_WG.inverse() * X_WL * mounts_[i].X_LB;
}

// Another posture that only moves links within the moving groups; false, nothing done, if it moves
// others or nothing is mounted yet.
bool StateChecker::remount(const RobotVector& q) {
  if (!mounted_) return false;
  const RobotVector& old = setup_.q[setup_.robot];
  const RobotModel& robot = model();
  moved_.assign(robot.links.size(), false);
  moved_links_.clear();
  for (const LinkId l : IdRange<LinkId>(robot.links.size())) {
    if (!robot.links[l].parent_joint.valid()) continue;
    const Joint& joint = robot.joints[robot.links[l].parent_joint];
    const bool changed = joint.dof.valid() && q[joint.dof.value()] != old[joint.dof.value()];
    if (!changed && !moved_[joint.parent_link]) continue;
    const int group = groups_.groupOf(l);
    if (group < 0 || groups_.linkOf(group) == l) return false;
    moved_[l] = true;
    moved_links_.push_back(l);
  }
  linkPosesOf(robot, q, moved_links_, X_WL_);
  for (std::size_t i = 0; i < mounts_.size(); ++i) {
    if (moved_[mounts_[i].link]) mountBody(i);
  }
  measured_ = false;
  return true;
}

void StateChecker::measureGroups() {
  setBalls(world_->scene(), moving_bodies_, groups_);
  measured_ = true;
}

const std::vector<MovingBody>& StateChecker::movingBodies() {
  if (stale_ || seen_changes_ != world_->changes()) activate();
  if (!measured_) measureGroups();
  return moving_bodies_;
}

void StateChecker::requireState(const Eigen::Ref<const Eigen::VectorXd>& q) const {
  require(q.size() == static_cast<Eigen::Index>(setup_.dofs.size()), "one position per moving dof");
  require(q.allFinite(), "positions must be finite");
}

void StateChecker::place(const Eigen::Ref<const Eigen::VectorXd>& q) {
  placeGroups(q);
  placeBodies();
}

void StateChecker::placeGroups(const Eigen::Ref<const Eigen::VectorXd>& q) {
  requireState(q);
  if (stale_ || seen_changes_ != world_->changes()) activate();
  groups_.place(q);
}

void StateChecker::placeBodies() {
  for (const MovingBody& it : moving_bodies_) {
    world_->setPose(it.body, groups_.pose(it.group) * it.X_GB);
  }
  seen_changes_ = world_->changes();
}

const MovingBody* StateChecker::tilting() const {
  if (!setup_.held || !setup_.held->tilt) return nullptr;
  const int held = moving_index_[world_->scene().objectBody(setup_.held->object)];
  return held < 0 ? nullptr : &moving_bodies_[static_cast<std::size_t>(held)];
}

bool StateChecker::valid(const Eigen::Ref<const Eigen::VectorXd>& q) {
  placeGroups(q);
  const MovingBody* held = tilting();
  if (held != nullptr && !setup_.held->tilt->keeps(groups_.pose(held->group) * held->X_GB)) {
    ++tilted_;
    return false;
  }
  placeBodies();
  const bool free = world_->isFree(pairs_);
  touched_ += free ? 0 : 1;
  return free;
}

bool StateChecker::keepsTilt(const JointMotion& motion, double from, double to) {
  if (stale_ || seen_changes_ != world_->changes()) activate();
  const MovingBody* held = tilting();
  return held == nullptr || handover::keepsTilt(groups_, held->group, held->X_GB.linear(),
                                                *setup_.held->tilt, motion, from, to);
}

std::optional<BodyContact> StateChecker::hit(const Eigen::Ref<const Eigen::VectorXd>& q) {
  place(q);
  BodyContact contact;
  if (world_->isFree(pairs_, &contact)) return std::nullopt;
  return contact;
}

bool StateChecker::freeAlong(const JointMotion& motion, double from, double to,
                             const Clearance& clearance, BodyContact* hit) {
  return freeAlong(pairs_, motion, from, to, clearance, hit);
}

bool StateChecker::freeAlong(const PairList& pairs, const JointMotion& motion, double from,
                             double to, const Clearance& clearance, BodyContact* hit) {
  movingBodies();
  const bool free = proof_.free(*world_, pairs, groups_, moving_bodies_, moving_index_, motion,
                                from, to, clearance, hit);
  seen_changes_ = world_->changes();
  return free;
}

bool StateChecker::isMotionFree(const JointMotion& motion, double from, double to,
                                const Clearance& clearance) {
  if (!keepsTilt(motion, from, to)) {
    ++tilted_;
    return false;
  }
  const bool free = freeAlong(motion, from, to, clearance, nullptr);
  touched_ += free ? 0 : 1;
  return free;
}

bool StateChecker::isMotionFree(const JointMotion& motion, const Clearance& clearance,
                                const std::optional<Clearance>& wide) {
  if (!wide) return isMotionFree(motion, 0, 1, clearance);
  return keepsTilt(motion) && freeAlong(wide_pairs_, motion, 0, 1, *wide, nullptr) &&
         freeAlong(close_pairs_, motion, 0, 1, clearance, nullptr);
}

std::optional<BodyContact> StateChecker::hitAlong(const JointMotion& motion, double from, double to,
                                                  const Clearance& clearance) {
  BodyContact contact;
  if (freeAlong(motion, from, to, clearance, &contact)) return std::nullopt;
  return contact;
}

std::optional<BodyPair> StateChecker::touching(const Part& part) {
  for (const std::size_t i : part.bodies) {
    const MovingBody& it = moving_bodies_[i];
    world_->setPose(it.body, groups_.pose(it.group) * it.X_GB);
  }
  seen_changes_ = world_->changes();
  return world_->touchingPair(pairs_, part.rows);
}

std::optional<BodyPair> StateChecker::toolTouches(const Pose& X_WTool) {
  require(setup_.tool_link.valid(), "no tool link");
  if (stale_ || seen_changes_ != world_->changes()) activate();
  const Pose X_WG = X_WTool * X_GTool_.inverse();
  for (const std::size_t i : tool_with_still_.bodies) {
    const MovingBody& it = moving_bodies_[i];
    world_->setPose(it.body, X_WG * it.X_GB);
  }
  seen_changes_ = world_->changes();
  return world_->touchingPair(pairs_, tool_with_still_.rows);
}

std::optional<BodyPair> StateChecker::armTouches(const Eigen::Ref<const Eigen::VectorXd>& q,
                                                 ArmPart part) {
  require(setup_.tool_link.valid(), "no tool link");
  requireState(q);
  if (stale_ || seen_changes_ != world_->changes()) activate();
  groups_.place(q);
  if (part == ArmPart::kAll) {
    if (auto pair = touching(arm_with_all_)) return pair;
  }
  return touching(tool_with_arm_);
}

std::vector<BodyContact> StateChecker::contacts(const Eigen::Ref<const Eigen::VectorXd>& q) {
  place(q);
  return world_->contacts(pairs_);
}

void StateChecker::setPosture(RobotId robot, const RobotVector& q) {
  RobotVector& posture = setup_.q.at(robot);
  require(q.size() == posture.size(), "a posture's size is wrong");
  if (robot == setup_.robot) {
    const bool light = !stale_ && remount(q);
    posture = q;
    if (light) return;
    mounted_ = false;
  }
  posture = q;
  stale_ = true;
}

void StateChecker::setObject(ObjectId object, const Pose& X_WO) {
  setup_.X_WO.at(object) = X_WO;
  stale_ = true;
}

void StateChecker::setHold(const Pose& X_LO) {
  require(setup_.held.has_value(), "nothing is held");
  setup_.held->X_LO = X_LO;
  const int held = moving_index_[world_->scene().objectBody(setup_.held->object)];
  if (held >= 0) mounts_[static_cast<std::size_t>(held)].X_LB = X_LO;
  stale_ = true;
  mounted_ = false;
}

}  // namespace handover
