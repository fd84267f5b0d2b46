// SPDX-License-Identifier: Apache-2.0
#include "brute_force.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

namespace handover::test {
namespace {

constexpr double kClear = 0.003;  // [m]
constexpr double kNeighbourhood =
    0.20;                            // [m], of the shoulders' midpoint: what the claims speak of
constexpr double kLattice = 0.05;    // [m]
constexpr double kLowered = 0.0017;  // [m], below what the planner and the contract ask for
constexpr int kTurns = 8;
constexpr double kOffLimits = 0.02;      // of a joint's range
constexpr int kFine = 90, kCoarse = 12;  // swivel angles, places of a slide

template <typename T>
bool contains(const std::vector<T>& all, const T& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

std::string text(const ArmVector& q) {
  std::ostringstream out;
  out << "(" << q.transpose() << ")";
  return out.str();
}

/// What the box stands on; nothing where it hangs.
std::vector<std::string> namesOf(const TaskRest& rest) {
  return rest.objects.value_or(std::vector<std::string>());
}

std::string text(const Pose& X) {
  std::ostringstream out;
  out << "[" << X.translation().transpose() << "]";
  return out.str();
}

}  // namespace

BruteForce::BruteForce(const RandomCell& cell)
    : cell_(cell), scene_(*cell.problem.scene), task_(cell.problem.task) {
  for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
    const RobotModel& model = *scene_.robots[r].model;
    for (std::size_t l = 0; l < model.links.size(); ++l) {
      if (model.links[l].collision.empty()) continue;
      Body& body = bodies_.emplace_back();
      body.name = scene_.robots[r].name + "/" + model.links[l].name;
      body.robot = RobotId(r);
      body.link = LinkId(l);
      const std::string& name = model.links[l].name;
      body.moves = l > 0;
      body.hand = name == "palm" || name == "left_finger" || name == "right_finger";
      for (const Shape& shape : model.links[l].collision) body.shapes.emplace_back(shape);
    }
  }
  for (std::size_t o = 0; o < scene_.objects.size(); ++o) {
    Body& body = bodies_.emplace_back();
    body.name = scene_.objects[o].name;
    body.object = ObjectId(o);
    body.moves = body.name == task_.object;
    for (const Shape& shape : scene_.objects[o].shapes) body.shapes.emplace_back(shape);
  }
}

const SmallRobot& BruteForce::small(Side side) const {
  return side == kGiver ? *cell_.giver : *cell_.receiver;
}

const Grasp& BruteForce::grasp(Side side, int index) const {
  return cell_.problem.resources[side].grasps.front()->grasps[static_cast<std::size_t>(index)];
}

BruteForce::State BruteForce::startState() const {
  State state;
  for (const SceneRobot& robot : scene_.robots) state.q.push_back(robot.q_start);
  state.X_WO = task_.X_WO_start;
  state.rest = namesOf(task_.start_rest);
  return state;
}

BruteForce::State BruteForce::goalState() const {
  State state = startState();
  state.X_WO = task_.X_WO_goal;
  state.rest.clear();
  if (task_.end == TransportEnd::kRelease) state.rest = namesOf(task_.goal_rest);
  return state;
}

void BruteForce::put(State& state, Side side, const ArmVector& q, double fingers) const {
  const RobotModel& model = *small(side).model;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    state.q[side][model.arms.front().dofs[static_cast<std::size_t>(i)].value()] = q[i];
  }
  state.q[side][model.hands.front().dofs.front().value()] = fingers;
}

std::vector<BruteForce::Hold> BruteForce::holds(Side side, const Pose& X_WO, int steps) const {
  std::vector<Hold> found;
  const Pose X_BW = scene_.robots[side].X_WB.inverse();
  const auto& grasps = cell_.problem.resources[side].grasps.front()->grasps;
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    for (const ArmVector& q : small(side).configurations(X_BW * X_WO * grasps[i].X_OT, steps)) {
      found.push_back({static_cast<int>(i), q});
    }
  }
  return found;
}

bool BruteForce::freeOpenAndClosed(const State& state, Side side, const Hold& hold) const {
  State open = state;
  put(open, side, hold.q, grasp(side, hold.grasp).open[0]);
  return !tight(open) && freeClosed(state, side, hold);
}

bool BruteForce::freeClosed(State state, Side side, const Hold& hold) const {
  put(state, side, hold.q, grasp(side, hold.grasp).closed[0]);
  (side == kGiver ? state.touch_giver : state.touch_receiver) = true;
  return !tight(state);
}

std::vector<BruteForce::Hold> BruteForce::freeHolds(Side side, const State& state, bool opens,
                                                    int steps) const {
  std::vector<Hold> found;
  for (const Hold& hold : holds(side, state.X_WO, steps)) {
    const bool free = opens ? freeOpenAndClosed(state, side, hold) : freeClosed(state, side, hold);
    if (free) found.push_back(hold);
  }
  return found;
}

std::vector<BruteForce::Hold> BruteForce::freePicks() const {
  return freeHolds(kGiver, startState(), true, kFine);
}

std::vector<BruteForce::Hold> BruteForce::freePlaces() const {
  return freeHolds(kReceiver, goalState(), task_.end == TransportEnd::kRelease, kFine);
}

bool BruteForce::mayTouch(const State& state, const Body& a, const Body& b) const {
  if (a.object.valid() && !b.object.valid()) return mayTouch(state, b, a);
  if (!a.moves && !b.moves) return true;
  if (a.robot.valid() && a.robot == b.robot) {
    return scene_.robots[a.robot].model->adjacent(a.link, b.link);
  }
  if (a.robot.valid()) {
    if (b.name != task_.object) return false;
    return a.hand && (a.robot == RobotId(static_cast<int>(kGiver)) ? state.touch_giver
                                                                   : state.touch_receiver);
  }
  if (a.name == task_.object) return contains(state.rest, b.name);
  return contains(state.rest, a.name);
}

std::vector<std::vector<Pose>> BruteForce::linkPosesAt(const State& state) const {
  std::vector<std::vector<Pose>> X_WL(scene_.robots.size());
  for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
    linkPoses(*scene_.robots[r].model, scene_.robots[r].X_WB, state.q[r], X_WL[r]);
  }
  return X_WL;
}

const Pose& BruteForce::poseOf(const Body& body, const State& state,
                               const std::vector<std::vector<Pose>>& X_WL) const {
  if (body.robot.valid()) {
    return X_WL[body.robot][body.link];
  }
  return body.name == task_.object ? state.X_WO : scene_.objects[body.object].X_WO;
}

bool BruteForce::near(const Body& a, const Pose& X_Wa, const Body& b, const Pose& X_Wb) {
  for (const FclShape& shape_a : a.shapes) {
    for (const FclShape& shape_b : b.shapes) {
      const double reach = shape_a.ball_radius + shape_b.ball_radius + kClear;
      const Eigen::Vector3d between = X_Wa * shape_a.ball_middle - X_Wb * shape_b.ball_middle;
      if (between.squaredNorm() > reach * reach) continue;
      if (fclDistance(shape_a, X_Wa, shape_b, X_Wb).low <= kClear) return true;
    }
  }
  return false;
}

std::optional<std::string> BruteForce::tight(const State& state, bool without_arms) const {
  const auto X_WL = linkPosesAt(state);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies_.size(); ++j) {
      const Body &a = bodies_[i], &b = bodies_[j];
      if (without_arms && ((a.robot.valid() && a.moves) || (b.robot.valid() && b.moves))) continue;
      if (mayTouch(state, a, b)) continue;
      if (near(a, poseOf(a, state, X_WL), b, poseOf(b, state, X_WL))) {
        return a.name + " and " + b.name;
      }
    }
  }
  return std::nullopt;
}

std::optional<std::string> BruteForce::tightStanding() const {
  const State state = startState();
  const auto X_WL = linkPosesAt(state);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies_.size(); ++j) {
      const Body &a = bodies_[i], &b = bodies_[j];
      if (a.moves || b.moves) continue;
      if (near(a, poseOf(a, state, X_WL), b, poseOf(b, state, X_WL))) {
        return a.name + " and " + b.name;
      }
    }
  }
  return std::nullopt;
}

bool BruteForce::offLimits(Side side, const ArmVector& q) const {
  const ArmKinematics& arm = *small(side).kinematics;
  const ArmVector room = kOffLimits * (arm.upper() - arm.lower());
  return ((q - arm.lower()).array() >= room.array()).all() &&
         ((arm.upper() - q).array() >= room.array()).all();
}

bool BruteForce::exchangeIsFree(const Pose& X_WH, const Hold& give, const Hold& receive) const {
  const Grasp& g = grasp(kGiver, give.grasp);
  const Grasp& r = grasp(kReceiver, receive.grasp);
  State state = startState();
  state.X_WO = X_WH;
  state.rest.clear();
  // The receiver comes with its hand open and closes it; the giver opens its own.
  state.touch_giver = true;
  put(state, kGiver, give.q, g.closed[0]);
  put(state, kReceiver, receive.q, r.open[0]);
  if (tight(state)) return false;
  state.touch_receiver = true;
  put(state, kReceiver, receive.q, r.closed[0]);
  if (tight(state)) return false;
  state.touch_giver = false;
  put(state, kGiver, give.q, g.open[0]);
  return !tight(state);
}

std::optional<std::string> BruteForce::handoverWithin(double radius) const {
  const auto picks = freePicks();
  const auto places = freePlaces();
  std::set<int> pickable, placeable;
  for (const Hold& hold : picks) pickable.insert(hold.grasp);
  for (const Hold& hold : places) placeable.insert(hold.grasp);
  if (pickable.empty() || placeable.empty()) return std::nullopt;

  const Eigen::Vector3d shoulder_g =
      scene_.robots[kGiver].X_WB * cell_.giver->kinematics->shoulder();
  const Eigen::Vector3d shoulder_r =
      scene_.robots[kReceiver].X_WB * cell_.receiver->kinematics->shoulder();
  const Eigen::Vector3d middle = 0.5 * (shoulder_g + shoulder_r);
  const Eigen::Vector3d z_shoulder = (shoulder_g - shoulder_r).normalized();
  const Pose X_BgW = scene_.robots[kGiver].X_WB.inverse();
  const Pose X_BrW = scene_.robots[kReceiver].X_WB.inverse();
  const int cells = static_cast<int>(std::ceil(radius / kLattice)) + 1;
  const Eigen::Array3i first = (middle / kLattice).array().floor().cast<int>() - cells;
  for (int n = 0; n < (2 * cells + 1) * (2 * cells + 1) * (2 * cells + 1); ++n) {
    const int side = 2 * cells + 1;
    const Eigen::Array3i index =
        first + Eigen::Array3i(n / (side * side), n / side % side, n % side);
    const Eigen::Vector3d p_W = kLattice * (index.cast<double>() + 0.5).matrix();
    if ((p_W - middle).norm() > radius) continue;
    for (int turn = 0; turn < kTurns; ++turn) {
      for (const int g_r : placeable) {
        const Pose X_WT_goal = task_.X_WO_goal * grasp(kReceiver, g_r).X_OT;
        Pose X_WT = Pose::Identity();
        X_WT.linear() = Eigen::AngleAxisd(2 * M_PI * turn / kTurns, z_shoulder).toRotationMatrix() *
                        Eigen::Quaterniond::FromTwoVectors(X_WT_goal.linear().col(0), z_shoulder)
                            .toRotationMatrix() *
                        X_WT_goal.linear();
        X_WT.translation() = p_W;
        const Pose X_WH = X_WT * grasp(kReceiver, g_r).X_OT.inverse();
        State alone = startState();
        alone.X_WO = X_WH;
        alone.rest.clear();
        for (const ArmVector& q_r : small(kReceiver).configurations(X_BrW * X_WT, kCoarse)) {
          if (!offLimits(kReceiver, q_r)) continue;
          const Hold receive{g_r, q_r};
          if (!freeOpenAndClosed(alone, kReceiver, receive)) continue;
          for (const int g_g : pickable) {
            for (const ArmVector& q_g :
                 small(kGiver).configurations(X_BgW * X_WH * grasp(kGiver, g_g).X_OT, kCoarse)) {
              const Hold give{g_g, q_g};
              if (!offLimits(kGiver, q_g)) continue;
              if (!exchangeIsFree(X_WH, give, receive)) continue;
              return "box at " + text(X_WH) + ", tool at " + text(X_WT) + " turn " +
                     std::to_string(turn) + ", giver's grasp " + std::to_string(g_g) + " by " +
                     text(q_g) + ", receiver's " + std::to_string(g_r) + " by " + text(q_r);
            }
          }
        }
      }
    }
  }
  return std::nullopt;
}

bool BruteForce::restsWhenLowered(const State& state) const {
  const auto box = std::find_if(bodies_.begin(), bodies_.end(),
                                [&](const Body& body) { return body.name == task_.object; });
  const Pose X_WO = Eigen::Translation3d(0, 0, -kLowered) * state.X_WO;
  for (const Body& body : bodies_) {
    if (!contains(state.rest, body.name)) continue;
    const Pose& X_WX = scene_.objects[body.object].X_WO;
    if (fclDistance(box->shapes.front(), X_WO, body.shapes.front(), X_WX).low <= 0) return true;
  }
  return false;
}

std::optional<std::string> BruteForce::against(FailureReason claim) const {
  const auto first = [](const std::vector<Hold>& found) -> std::optional<std::string> {
    if (found.empty()) return std::nullopt;
    return "grasp " + std::to_string(found.front().grasp) + " by " + text(found.front().q);
  };
  switch (claim) {
    case FailureReason::kStartUnreachable:
      return first(holds(kGiver, task_.X_WO_start, kFine));
    case FailureReason::kGoalUnreachable:
      return first(holds(kReceiver, task_.X_WO_goal, kFine));
    case FailureReason::kNoGraspAtStart:
      return first(freePicks());
    case FailureReason::kNoGraspAtGoal:
      return first(freePlaces());
    case FailureReason::kNoCommonWorkspace:
    case FailureReason::kNoHandoverPose:
      return handoverWithin(kNeighbourhood);
    case FailureReason::kStartInCollision:
      if (!tight(startState()) && !tightStanding())
        return "nothing is nearer than 3 mm at the start";
      return std::nullopt;
    case FailureReason::kGoalInCollision:
      // From a box that is held arms can move away; at the end of the others they are at home.
      if (!tight(goalState(), task_.end == TransportEnd::kHold)) {
        return "nothing is nearer than 3 mm to the box at its goal";
      }
      return std::nullopt;
    case FailureReason::kStartUnsupported:
      if (restsWhenLowered(startState())) return "the box rests at its start";
      return std::nullopt;
    case FailureReason::kGoalUnsupported:
      if (restsWhenLowered(goalState())) return "the box rests at its goal";
      return std::nullopt;
    default:
      throw std::logic_error(std::string("no claim of impossibility: ") + toString(claim));
  }
}

}  // namespace handover::test
