// SPDX-License-Identifier: Apache-2.0
// Where everything is at one moment of a plan, and tests of arm configurations against it.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/collision/state_checker.hpp"
#include "core/handover/manipulator.hpp"

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace handover {

/// All robots' joints and the place of the object handed over; everything else stands as in the
/// scene.
struct CellState {
  std::vector<RobotVector> q;           ///< per robot of the scene
  Pose X_WO = Pose::Identity();         ///< when nobody holds it, or where the holder has it
  const Manipulator* holder = nullptr;  ///< the object moves with this role's tool
  Pose X_TO = Pose::Identity();         ///< in the holder's tool
};

/// Which contacts with the object a stage allows beyond the standing pairs (design §5's table).
/// What the object rests on is a standing pair in the file but allowed here only where a stage says
/// so.
struct AllowedContacts {
  bool giver_hand = false;
  bool receiver_hand = false;
  bool start_rest = false;
  bool goal_rest = false;

  bool operator==(const AllowedContacts&) const = default;
};

/// The collision scene that a task is planned in: as the scene, but what the object rests on is no
/// standing pair, so that it counts once the object is carried away.
std::shared_ptr<const CollisionScene> collisionForTask(const Scene& scene,
                                                       const std::string& object);

/// The fixed facts of one request that state checks need; makes checkers. Not thread-safe.
class CollisionContext {
 public:
  /// @pre the arguments outlive the factory.
  CollisionContext(const HandoverProblem& problem, const Manipulator& giver,
                   const Manipulator& receiver, CollisionWorld& world);

  CellState startState() const;

  int object() const { return object_; }

  BodyId objectBody() const { return object_body_; }

  BodyPairs allowed(const AllowedContacts& contacts) const;

  /// A checker for motions of `dofs` of the mover's robot while all else stands as in `state`.
  StateChecker make(const CellState& state, const Manipulator& mover, const std::vector<int>& dofs,
                    const AllowedContacts& contacts) const;

  /// Names of the pairs that `contacts` allows, for the plan's may_touch: sorted.
  std::vector<NamePair> names(const AllowedContacts& contacts) const;

 private:
  /// What a checker's pairs follow from, and one that has them: finding them costs more than a
  /// copy.
  struct Pattern {
    int robot;
    std::vector<int> dofs;
    bool holding;
    AllowedContacts contacts;
    StateChecker checker;
  };

  const StateChecker& pattern(const Manipulator& mover, const std::vector<int>& dofs, bool holding,
                              const AllowedContacts& contacts) const;

  const HandoverProblem& problem_;
  const Manipulator& giver_;
  const Manipulator& receiver_;
  CollisionWorld& world_;
  int object_ = -1;
  BodyId object_body_ = -1;
  std::vector<BodyId> start_rest_, goal_rest_;
  mutable std::deque<Pattern> patterns_;
};

}  // namespace handover
