// SPDX-License-Identifier: Apache-2.0
// Where everything is at one moment of a plan, and checkers of arm configurations against it.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/collision/state_checker.hpp"
#include "core/planning/manipulator.hpp"
#include "core/task/stages.hpp"

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace handover {

/// All robots' joints and the place of the object handed over; everything else stands as in the
/// scene.
struct CellState {
  std::vector<RobotVector> q;           ///< per robot of the scene
  Pose X_WO = Pose::Identity();         ///< when nobody moves it, or where the holder has it
  const Manipulator* holder = nullptr;  ///< the object moves with its tool
  Pose X_TO = Pose::Identity();         ///< in the holder's tool

  const RobotVector& of(const Manipulator& manipulator) const { return q[manipulator.robot]; }

  RobotVector& of(const Manipulator& manipulator) { return q[manipulator.robot]; }
};

/// The object in the manipulator's hand, closed by the grasp, at an arm configuration.
CellState holding(CellState state, const Manipulator& manipulator, const Grasp& grasp,
                  const ArmVector& q);

/// How a task's object stands at its ends: which of its axes leans (that of `upright`, else its z),
/// and the larger angle to world z of start and goal.
TiltLimit tiltAtEnds(const SceneTask& task);

/// How far the task's object may lean in a hand (design §5, Upright); nullopt: however it likes.
std::optional<TiltLimit> tiltLimitOf(const SceneTask& task);

/// Contacts of a holder's open hand at the object: a cup stands nearer to it than the margins reach
/// (kCupGap), and so for the straight way there and back. That it keeps kCupClearance until its
/// grasp begins is proven of the timed approach.
AllowedContacts besideObject(AllowedContacts contacts, std::size_t holder, const Manipulator& arm);

inline constexpr Clearance kCupClearance{0.0005, 0.00025};
static_assert(kCupClearance.looked < kCupGap);

/// The collision scene that a task is planned in: as the scene, but the object stands on nothing,
/// so that what it rests on counts once it is carried away.
std::shared_ptr<const CollisionScene> collisionForTask(const Scene& scene,
                                                       const std::string& object);

/// Makes checkers for a chain of holders; the fixed facts of one request that these need. One per
/// worker, like its world.
class CollisionContext {
 public:
  /// @pre the arguments outlive the context; the task's rests are known.
  CollisionContext(const TransportProblem& problem, std::vector<const Manipulator*> holders,
                   CollisionWorld& world);

  CellState startState() const;

  ObjectId object() const { return object_; }

  BodyId objectBody() const { return object_body_; }

  /// How far the object may lean while it is held.
  const std::optional<TiltLimit>& tilt() const { return tilt_; }

  /// A checker for motions of `dofs` of the mover's robot while all else stands as in `state`; what
  /// it holds keeps the task's tilt.
  StateChecker make(const CellState& state, const Manipulator& mover,
                    const std::vector<DofId>& dofs, const AllowedContacts& contacts);

  /// Of the mover's arm.
  StateChecker makeForArm(const CellState& state, const Manipulator& mover,
                          const AllowedContacts& contacts) {
    return make(state, mover, mover.arm_model->dofs, contacts);
  }

  /// Names of the pairs that `contacts` allows, for the plan's may_touch: sorted.
  std::vector<NamePair> names(const AllowedContacts& contacts) const;

 private:
  /// What a checker's pairs follow from, and one that has them: finding them costs more than a
  /// copy.
  struct Pattern {
    RobotId robot;
    std::vector<DofId> dofs;
    bool holding;
    AllowedContacts contacts;
    StateChecker checker;
  };

  /// Calls visit(body) for every body that may touch the object.
  template <typename Visit>
  void forEachPartner(const AllowedContacts& contacts, const Visit& visit) const;
  void markClose(const Manipulator& mover, bool holding, BodyPairs& close) const;
  const StateChecker& pattern(const Manipulator& mover, const std::vector<DofId>& dofs,
                              bool holding, const AllowedContacts& contacts);

  const TransportProblem& problem_;
  std::vector<const Manipulator*> holders_;
  CollisionWorld& world_;
  ObjectId object_;
  BodyId object_body_;
  std::optional<TiltLimit> tilt_;
  std::vector<BodyId> start_rest_, goal_rest_;
  std::vector<bool> of_hand_;      ///< by body: of one of the holders
  std::vector<RobotId> carriers_;  ///< by body: the robot that it is a part of, or hangs on
  std::deque<Pattern> patterns_;
};

}  // namespace handover
