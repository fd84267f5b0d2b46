// SPDX-License-Identifier: Apache-2.0
// Is one robot's configuration free of contact while everything else stands still, and what it
// holds upright? The question that grasp pruning and motion planning ask by the thousand.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/collision/continuous_collision_checker.hpp"
#include "core/collision/joint_motion.hpp"
#include "core/collision/rigid_groups.hpp"
#include "core/collision/tilt_limit.hpp"

namespace handover {

/// An object that moves with a link of the moving robot.
struct HeldObject {
  ObjectId object;  ///< the one held
  LinkId link;      ///< of the moving robot
  Pose X_LO = Pose::Identity();
  std::optional<TiltLimit> tilt{};
};

/// What moves, and where everything else stands meanwhile.
struct StateCheckerSetup {
  /// Robots at q_start, objects at their places, nothing held, nothing allowed.
  StateCheckerSetup(const CollisionScene& scene, RobotId moving_robot,
                    std::vector<DofId> moving_dofs);

  RobotId robot;  ///< the moving robot
  std::vector<DofId>
      dofs;  ///< its moving dofs (an arm's, a hand's), in the order of the states asked
  std::vector<RobotVector>
      q;  ///< by robot; of the moving one, the joints that are not in `dofs` count
  /// By object. Those that the scene attaches to a link go with that link whatever stands here,
  /// unless they are held.
  std::vector<Pose> X_WO;
  std::optional<HeldObject> held;
  BodyPairs allowed;  ///< pairs that may touch, beyond the standing ones
  BodyPairs close;    ///< pairs of which no wide clearance is asked
  LinkId tool_link;   ///< of the moving robot: for toolTouches() and armTouches()
};

/// Tests states of some joints of one robot: their links, and the objects these carry, against each
/// other and against everything else; pairs that move as one, standing and allowed pairs left out.
/// So a hand whose fingers stand still is never tested against itself.
/// Several checkers may share one world: each sets the whole scene anew when someone else has moved
/// anything in it since its own last state. Changing between checkers state by state is thus slow.
/// Not thread-safe, like its world, which must outlive it. No allocation per state.
class StateChecker {
 public:
  /// @throws std::invalid_argument for indices out of range, sizes that do not fit, poses not
  /// finite.
  StateChecker(CollisionWorld& world, StateCheckerSetup setup);

  /// Puts the whole scene in place: robots, objects; the moving joints where they stand in the
  /// setup. Optional: valid() and hit() do it when it is needed.
  void activate();

  /// True when nothing touches at these positions of `dofs` [rad or m], and what is held keeps its
  /// tilt. The joints' limits are not looked at.
  /// @throws std::invalid_argument when the size is wrong or an entry is not finite.
  bool valid(const Eigen::Ref<const Eigen::VectorXd>& q);
  /// The first touching pair found; always the same one for the same q.
  std::optional<BodyContact> hit(const Eigen::Ref<const Eigen::VectorXd>& q);
  /// True when what is held keeps its tilt (keepsTilt()) and no pair comes into contact anywhere on
  /// the motion between two of its parameters: all along it the shapes keep `clearance.proven`. A
  /// pair is looked at as often as its distance and the travel of its links ask for, by halving the
  /// motion (Schwarzer, Saha, Latombe 2005).
  /// @throws std::invalid_argument when its states have the wrong size or are not finite.
  bool isMotionFree(const JointMotion& motion, double from = 0, double to = 1,
                    const Clearance& clearance = kPlannedClearance);
  /// The same where the pairs that are not close keep `wide` clearance.
  bool isMotionFree(const JointMotion& motion, const Clearance& clearance,
                    const std::optional<Clearance>& wide);
  /// True when what is held, if it has a limit, keeps it all along the motion.
  bool keepsTilt(const JointMotion& motion, double from = 0, double to = 1);
  /// A pair that touches on the motion, if any.
  std::optional<BodyContact> hitAlong(const JointMotion& motion, double from = 0, double to = 1,
                                      const Clearance& clearance = kPlannedClearance);
  /// valid() in parts, for callers that ask many states with the tool at one pose. This part is a
  /// function of that pose: what moves as one with the setup's tool link, against all that stands
  /// still. A touching pair, if any.
  std::optional<BodyPair> toolTouches(const Pose& X_WTool);
  /// Which of the other pairs of a state to test: those of the tool's bodies with the links before
  /// them, or all.
  enum class ArmPart { kToolWithArm, kAll };
  std::optional<BodyPair> armTouches(const Eigen::Ref<const Eigen::VectorXd>& q, ArmPart part);
  /// Every touching pair.
  std::vector<BodyContact> contacts(const Eigen::Ref<const Eigen::VectorXd>& q);
  /// Moves everything to q without testing, e.g. to ask world().distance().
  void place(const Eigen::Ref<const Eigen::VectorXd>& q);

  /// Another posture of one robot (of the moving one: its joints that are not in `dofs`). Cheap
  /// where only what hangs on moving links changes, like the fingers of a moving hand.
  void setPosture(RobotId robot, const RobotVector& q);
  /// Another place of an object that is neither held nor attached.
  void setObject(ObjectId object, const Pose& X_WO);
  /// Another hold of the held object. @pre the setup holds one.
  void setHold(const Pose& X_LO);

  CollisionWorld& world() { return *world_; }

  /// How many states and motions fell because what is held would have leaned too far, and how many
  /// by a contact.
  std::uint32_t tilted() const { return tilted_; }

  std::uint32_t touched() const { return touched_; }

  /// Bodies that move, carried objects included.
  const std::vector<BodyId>& moving() const { return moving_; }

  const PairList& pairs() const { return pairs_; }

  const StateCheckerSetup& setup() const { return setup_; }

  /// The moving bodies with what moves them, put in place and measured as the setup has it; valid
  /// until the setup changes. So are the groups from then on.
  const std::vector<MovingBody>& movingBodies();

  const RigidGroups& groups() const { return groups_; }

 private:
  /// Where a moving body hangs: its link, and its pose there.
  struct Mount {
    LinkId link;
    Pose X_LB;
  };

  const RobotModel& model() const;
  void compile();
  void requireState(const Eigen::Ref<const Eigen::VectorXd>& q) const;

  /// Some rows of pairs_, and the bodies that they speak of.
  struct Part {
    std::vector<PairList::Row> rows;
    std::vector<std::size_t> bodies;  ///< in moving_bodies_
  };

  void divide();
  std::optional<BodyPair> touching(const Part& part);
  void mountBodies();
  void mountBody(std::size_t i);
  bool remount(const RobotVector& q);
  /// What moves as one is measured once per posture.
  void measureGroups();
  void divideByClearance();
  bool freeAlong(const PairList& pairs, const JointMotion& motion, double from, double to,
                 const Clearance& clearance, BodyContact* hit);
  bool freeAlong(const JointMotion& motion, double from, double to, const Clearance& clearance,
                 BodyContact* hit);
  void placeGroups(const Eigen::Ref<const Eigen::VectorXd>& q);
  void placeBodies();
  /// What is held under a limit and moves; nullptr: nothing.
  const MovingBody* tilting() const;

  CollisionWorld* world_;
  StateCheckerSetup setup_;
  RigidGroups groups_;
  std::vector<BodyId> moving_;
  std::vector<Mount> mounts_;              ///< of the moving bodies, in their order
  std::vector<MovingBody> moving_bodies_;  ///< the same bodies
  std::vector<int> moving_index_;          ///< by body; -1: stands still
  PairList pairs_;
  PairList close_pairs_, wide_pairs_;  ///< all of pairs_
  std::uint64_t seen_changes_ = 0;     ///< of the world, at the last state asked
  bool stale_ = true;                  ///< the setup changed since
  bool mounted_ = false;               ///< moving_bodies_ are those of the setup
  bool measured_ = false;              ///< groups_ knows the balls of moving_bodies_
  std::uint32_t tilted_ = 0, touched_ = 0;
  Pose X_GTool_ = Pose::Identity();
  Part tool_with_still_, tool_with_arm_, arm_with_all_;

  std::vector<Pose> X_WL_;  ///< of the moving robot at the setup's posture

  // Scratch.
  std::vector<bool> moved_;  ///< by link
  std::vector<LinkId> moved_links_;
  ContinuousCollisionChecker proof_;
};

}  // namespace handover
