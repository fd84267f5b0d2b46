// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/finger_closing.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

using Eigen::VectorXd;

constexpr double kLookAhead = 0.04;  // distances are asked for up to this [m]
constexpr double kExact = 0.002;  // nearer to the parts than this, the surface itself is asked [m]
constexpr double kWidest = 1;     // opening that is looked for [m]
constexpr double kCloses = 1e-3;  // links that come nearer than this face each other [m]
constexpr int kMaxSteps = 200;    // of one joint's closing; seen: below 60
constexpr double kLineSkin = 1e-4;  // fingers on their way to the contact stay this far off [m]
constexpr double kOpenings[] = {0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 1.0};

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// Farthest point of a link and all beyond it from the link's own origin, whatever the posture.
double reachOf(const RobotModel& model, LinkId link) {
  double reach = 0;
  for (const auto& p : outline(model.links[link])) reach = std::max(reach, p.norm());
  return reach * 1.01;  // round shapes are drawn by inscribed facets
}

/// How far a point of a link moves at most while a dof moves by 1, whatever the posture: the link's
/// own extent and the joints between it and the dof's axis.
double speedOf(const RobotModel& model, LinkId link, DofId dof) {
  double arm_length = reachOf(model, link);
  double speed = 0;
  for (LinkId l = link; l != LinkId(0);) {
    const Joint& joint = model.joints[model.links[l].parent_joint];
    if (joint.type != JointType::kFixed && joint.dof == dof) {
      const double factor = joint.mimic ? std::abs(joint.mimic_multiplier) : 1.0;
      speed += factor * (joint.type == JointType::kRevolute ? arm_length : 1.0);
    }
    if (joint.type == JointType::kPrismatic)
      arm_length += std::max(std::abs(joint.lower), std::abs(joint.upper));
    arm_length += joint.X_PJ.translation().norm();
    l = joint.parent_link;
  }
  return speed;
}

}  // namespace

FingerClosing::FingerClosing(const SceneObject& object, HandModel hand, const GraspRules& rules)
    : hand_(std::move(hand)),
      rules_(rules),
      surface_(object),
      grip_(surface_, hand_),
      divided_(object.divided || std::any_of(hand_.model->links.begin(), hand_.model->links.end(),
                                             [](const Link& link) { return link.divided; })),
      object_parts_(object.shapes),
      world_(handAndObject(object, hand_)) {
  const RobotModel& model = *hand_.model;
  const IdRange<LinkId> links(model.links.size());
  const CollisionScene& scene = world_.scene();
  object_ = scene.objectBody(ObjectId(0));
  is_finger_.assign(model.links.size(), false);
  for (const LinkId link : hand_.hand.finger_links) is_finger_[link] = true;
  finger_.assign(model.links.size(), -1);
  for (int finger = static_cast<int>(hand_.hand.fingers.size()) - 1; finger >= 0; --finger) {
    for (const LinkId link : model.linksMovedBy(hand_.hand.fingers[at(finger)]))
      finger_[link] = finger;
  }
  for (const LinkId link : links) {
    link_body_.push_back(scene.linkBody(RobotId(0), link));
    link_parts_.emplace_back(model.links[link].collision);
    if (link_body_.back().valid()) links_.push_back(link);
  }
  guardSelfPairs();
  for (const DofId dof : hand_.hand.dofs) addMovers(dof);
}

void FingerClosing::guardSelfPairs() {
  // Pairs that are already close with the hand open stay as they are there: that is the hand's
  // build.
  set(Pose::Identity(), hand_.hand.open);
  const BodyPairs& standing = world_.scene().standingPairs();
  for (std::size_t k = 1; k < links_.size(); ++k) {
    for (std::size_t i = 0; i < k; ++i) {
      const BodyId a = link_body_[links_[i]], b = link_body_[links_[k]];
      if (standing.contains(a, b)) continue;
      const auto open = world_.distance(a, b, rules_.self_clearance);
      if (open && open->distance <= 0) continue;
      const double needed =
          open ? std::min(rules_.self_clearance, open->distance - 1e-4) : rules_.self_clearance;
      self_pairs_.push_back({a, b, links_[i], links_[k], needed});
    }
  }
}

void FingerClosing::addMovers(DofId dof) {
  const RobotModel& model = *hand_.model;
  const std::vector<LinkId> moved = model.linksMovedBy({dof});
  std::vector<bool> moves(model.links.size(), false);
  for (const LinkId link : moved) moves[link] = true;
  std::vector<Mover> movers;
  for (const LinkId link : moved) {
    const BodyId body = link_body_[link];
    if (body.valid()) movers.push_back({link, body, speedOf(model, link, dof)});
  }
  std::vector<SelfPair> guarded;
  for (const SelfPair& pair : self_pairs_) {
    if (moves[pair.link_a] != moves[pair.link_b] || (moves[pair.link_a] && moved.size() > 1)) {
      guarded.push_back(pair);
    }
  }
  movers_.push_back(std::move(movers));
  guarded_.push_back(std::move(guarded));
}

int FingerClosing::fingerOf(const std::string& link) const {
  const LinkId index = hand_.model->findLink(link);
  return index.valid() ? finger_[index] : -1;
}

std::vector<double> FingerClosing::fingersApart(const VectorXd& q) {
  set(Pose::Identity(), q);
  std::vector<double> apart;
  for (const LinkId a : hand_.hand.finger_links) {
    for (const LinkId b : hand_.hand.finger_links) {
      if (a >= b || !link_body_[a].valid() || !link_body_[b].valid()) continue;
      const auto found = world_.distance(link_body_[a], link_body_[b], kWidest);
      apart.push_back(found ? found->distance : kWidest);
    }
  }
  return apart;
}

double FingerClosing::opening() {
  const std::vector<double> open = fingersApart(hand_.hand.open);
  const std::vector<double> closed = fingersApart(hand_.hand.closed);
  double widest = 0;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (closed[i] < open[i] - kCloses) widest = std::max(widest, open[i]);
  }
  return widest;
}

void FingerClosing::set(const Pose& X_OT, const VectorXd& q) {
  const RobotModel& model = *hand_.model;
  RobotVector posture = restingPosture(model);
  for (std::size_t i = 0; i < hand_.hand.dofs.size(); ++i)
    posture[hand_.hand.dofs[i].value()] = q[static_cast<Eigen::Index>(i)];
  linkPoses(model, X_OT * hand_.X_RT.inverse(), posture, X_WL_);
  world_.setRobot(RobotId(0), X_WL_);
}

template <typename Distance>
double FingerClosing::handTo(double max, double enough, const Distance& distance) {
  double least = max;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const auto found = distance(links_[i], least);
    if (!found) continue;
    least = found->distance;
    // The next pose is much like this one: what is nearest now spares most of the others then.
    std::swap(links_[0], links_[i]);
    if (least < enough) break;
  }
  return least;
}

double FingerClosing::handToParts(double max, double enough) {
  return handTo(max, enough, [&](LinkId link, double least) {
    return world_.distance(link_body_[link], object_, least);
  });
}

double FingerClosing::handToSurface(double max, double enough) {
  return handTo(max, enough, [&](LinkId link, double least) { return toSurface(link, least); });
}

std::optional<BodyDistance> FingerClosing::toSurface(LinkId link, double max) {
  if (!divided_) return world_.distance(link_body_[link], object_, max);
  // Parts cover the surface: it is no nearer than they are.
  const Pose& X_OL = X_WL_[link];
  const auto parts =
      SurfaceTree::distance(link_parts_[link], X_OL, object_parts_, Pose::Identity(), max);
  if (!parts || parts->distance > kExact) return parts;
  return SurfaceTree::distance(grip_.link(link), X_OL, surface_.tree(), Pose::Identity(), max);
}

std::optional<double> FingerClosing::advance(const Pose& X_OT, const VectorXd& q, double far,
                                             double near) {
  double back = far;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d offset_T = -back * hand_.approach_T;
    set(X_OT * Eigen::Translation3d(offset_T), q);
    const double slack =
        handToParts(kLookAhead + rules_.clearance, rules_.clearance) - rules_.clearance;
    if (slack < 0) return step == 0 ? std::nullopt : std::optional<double>(back + 1e-3);
    if (slack < 5e-4 || back <= near) return back;
    back = std::max(near, back - slack);
  }
  return back;
}

double FingerClosing::freeTravel(int dof) {
  double fastest = 1e-6;
  for (const Mover& mover : movers_[at(dof)]) fastest = std::max(fastest, mover.reach);
  // Nobody is asked for more than would still shorten the travel.
  double travel = kLookAhead / fastest;
  const auto shortened = [&](const std::optional<BodyDistance>& found, double speed,
                             double needed) {
    if (!found) return true;
    const double gap = found->distance - needed;
    travel = std::min(travel, gap / speed);
    return gap > rules_.gap_tolerance;
  };
  for (const Mover& mover : movers_[at(dof)]) {
    const double speed = std::max(mover.reach, 1e-6);
    const auto near = toSurface(mover.link, travel * speed + rules_.contact_gap);
    if (!shortened(near, speed, rules_.contact_gap)) return 0;
  }
  for (const SelfPair& pair : guarded_[at(dof)]) {
    const auto near = world_.distance(pair.a, pair.b, travel * fastest + pair.needed);
    if (!shortened(near, fastest, pair.needed)) return 0;
  }
  return travel;
}

void FingerClosing::closeJoint(const Pose& X_OT, int dof, VectorXd& q) {
  const double end = hand_.hand.closed[dof];
  for (int step = 0; step < kMaxSteps && q[dof] != end; ++step) {
    set(X_OT, q);
    const double travel = freeTravel(dof);
    if (travel <= 0) return;
    const double left = end - q[dof];
    q[dof] = std::abs(left) <= travel ? end : q[dof] + std::copysign(travel, left);
  }
}

VectorXd FingerClosing::close(const Pose& X_OT, const VectorXd& open) {
  VectorXd q = open;
  const std::vector<DofId>& dofs = hand_.hand.dofs;
  for (const auto& finger : hand_.hand.fingers) {
    for (const DofId dof : finger) {
      const auto found = std::find(dofs.begin(), dofs.end(), dof);
      if (found == dofs.end()) continue;
      closeJoint(X_OT, static_cast<int>(found - dofs.begin()), q);
    }
  }
  return q;
}

std::vector<GraspContact> FingerClosing::contacts(const Pose& X_OT, const VectorXd& closed) {
  set(X_OT, closed);
  const RobotModel& model = *hand_.model;
  std::vector<GraspContact> found;
  std::vector<double> distance;
  for (const LinkId link : IdRange<LinkId>(model.links.size())) {
    const BodyId body = link_body_[link];
    if (!body.valid()) continue;
    const bool finger = is_finger_[link];
    const auto near = finger ? toSurface(link, rules_.contact_range)
                             : world_.distance(body, object_, rules_.clearance - 1e-3);
    if (!near) continue;
    if (!finger || near->distance < 0.25 * rules_.contact_gap) return {};
    found.push_back({model.links[link].name, near->p_Wb, near->n_W});
    distance.push_back(near->distance);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t j = i + 1; j < found.size(); ++j) {
      if (std::max(distance[i], distance[j]) > rules_.opposing_range) continue;
      if (found[i].n_O.dot(found[j].n_O) < std::cos(rules_.opposing_angle)) {
        return grip_.holds(X_WL_) ? found : std::vector<GraspContact>();
      }
    }
  }
  return {};
}

bool FingerClosing::lineIsFree(const Pose& X_OT, const VectorXd& from, const VectorXd& to) {
  const VectorXd way = to - from;
  double speed = 1e-6;  // greatest of any link over the whole line
  for (const LinkId link : links_) {
    double own = 0;
    for (std::size_t i = 0; i < movers_.size(); ++i) {
      for (const Mover& mover : movers_[i]) {
        if (mover.link == link) own += mover.reach * std::abs(way[static_cast<Eigen::Index>(i)]);
      }
    }
    speed = std::max(speed, own);
  }
  for (double s = 0; s < 1;) {
    set(X_OT, from + s * way);
    const double slack = handToSurface(kLookAhead, kLineSkin) - kLineSkin;
    if (slack < 0) return false;
    for (const SelfPair& pair : self_pairs_) {
      const auto near = world_.distance(pair.a, pair.b, pair.needed);
      if (near && near->distance < pair.needed - 3e-4) return false;
    }
    s += std::clamp(slack / speed, 0.01, 0.1);
  }
  return true;
}

std::optional<VectorXd> FingerClosing::leastOpening(const Pose& X_OT, const VectorXd& closed,
                                                    const VectorXd& open) {
  for (const double part : kOpenings) {
    const VectorXd opening = closed + part * (open - closed);
    set(X_OT, opening);
    if (handToParts(rules_.clearance, rules_.clearance) < rules_.clearance) continue;
    const auto back = advance(X_OT, opening, rules_.retreat, 0.0);
    if (!back || *back > 0) continue;
    if (!lineIsFree(X_OT, closed, opening))
      return std::nullopt;  // a wider one starts on the same line
    return opening;
  }
  return std::nullopt;
}

double handOpening(const RobotModel& model, ArmId arm) {
  SceneObject speck;
  speck.name = "speck";
  speck.shapes = {{Pose::Identity(), SphereShape{1e-3}}};
  return FingerClosing(speck, extractEndEffector(model, arm), GraspRules{}).opening();
}

}  // namespace handover
