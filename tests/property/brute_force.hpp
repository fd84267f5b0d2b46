// SPDX-License-Identifier: Apache-2.0
// Looks for what the planner said does not exist, by going through everything: all configurations
// by hand-made inverse kinematics, clearances by FCL, no maps, no order, no limits on how much is
// tried.
#pragma once

#include "random_cell.hpp"
#include "support/fcl_shapes.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace handover::test {

class BruteForce {
 public:
  /// @pre the cell outlives this.
  explicit BruteForce(const RandomCell& cell);

  /// What shows that the claim is wrong, or nothing. A witness keeps every pair of bodies 3 mm
  /// apart, one more than the planner asks for, so that rounding decides nothing; at the handover
  /// it keeps 2 % of each joint's range off the limits: maps are samples, and end where few fall.
  ///   start_unreachable, goal_unreachable    a grasp that some configuration reaches
  ///   no_grasp_at_start, no_grasp_at_goal    ... with the hand free, open and closed
  ///   no_common_workspace, no_handover_pose  a lattice point near the middle of the shoulders, a
  ///                                          turn, a free grasp of each hand
  ///   start_in_collision, goal_in_collision  that nothing is nearer than 3 mm
  ///   start_unsupported, goal_unsupported    that the box, lowered by 1.7 mm, touches its rest
  std::optional<std::string> against(FailureReason claim) const;

  /// A handover as above at lattice points within `radius` [m] of the middle of the shoulders.
  std::optional<std::string> handoverWithin(double radius) const;

 private:
  enum Side { kGiver = 0, kReceiver = 1 };

  struct Body {
    std::string name;
    RobotId robot;
    LinkId link;
    ObjectId object;
    bool moves = false;  ///< a link beyond the base, or the box
    bool hand = false;
    std::vector<FclShape> shapes;
  };

  /// A whole cell: both robots, the box.
  struct State {
    std::vector<RobotVector> q;
    Pose X_WO = Pose::Identity();
    bool touch_giver = false, touch_receiver = false;  ///< hands that may touch the box
    std::vector<std::string> rest;                     ///< objects that the box may touch
  };

  /// A grasp with a configuration that holds the box there.
  struct Hold {
    int grasp = -1;
    ArmVector q;
  };

  const SmallRobot& small(Side side) const;
  const Grasp& grasp(Side side, int index) const;
  State startState() const;
  State goalState() const;
  void put(State& state, Side side, const ArmVector& q, double fingers) const;
  std::vector<Hold> holds(Side side, const Pose& X_WO, int steps) const;
  std::vector<Hold> freeHolds(Side side, const State& state, bool opens, int steps) const;
  std::vector<Hold> freePicks() const;
  std::vector<Hold> freePlaces() const;
  bool freeOpenAndClosed(const State& state, Side side, const Hold& hold) const;
  bool freeClosed(State state, Side side, const Hold& hold) const;
  bool mayTouch(const State& state, const Body& a, const Body& b) const;
  std::vector<std::vector<Pose>> linkPosesAt(const State& state) const;
  const Pose& poseOf(const Body& body, const State& state,
                     const std::vector<std::vector<Pose>>& X_WL) const;
  /// Within 3 mm of each other.
  static bool near(const Body& a, const Pose& X_Wa, const Body& b, const Pose& X_Wb);
  bool restsWhenLowered(const State& state) const;
  /// The first pair nearer than 3 mm, of all or of those that no motion of an arm can part.
  std::optional<std::string> tight(const State& state, bool without_arms = false) const;
  /// ... of those of which neither can move.
  std::optional<std::string> tightStanding() const;
  bool offLimits(Side side, const ArmVector& q) const;
  bool exchangeIsFree(const Pose& X_WH, const Hold& give, const Hold& receive) const;

  const RandomCell& cell_;
  const Scene& scene_;
  const SceneTask& task_;
  std::vector<Body> bodies_;
};

}  // namespace handover::test
