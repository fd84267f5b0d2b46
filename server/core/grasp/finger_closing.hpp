// SPDX-License-Identifier: Apache-2.0
// A hand beside an object: moves it up along the approach, closes its fingers until contact,
// measures. An open hand keeps off the object's convex parts, as plans will; fingers close on its
// own surface.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "core/grasp/grasp_set.hpp"
#include "core/grasp/grip_rule.hpp"
#include "core/grasp/hand_model.hpp"
#include "core/grasp/object_surface.hpp"

#include <optional>
#include <vector>

namespace handover {

/// Distances that make a grasp legal; all with reserve over what the planner and a verifier ask
/// for.
struct GraspRules {
  double clearance = 0.004;  ///< open hand, palm and wrist to the object: margins touch below 2 mm
  double self_clearance = 0.0025;             ///< hand's links among each other
  double contact_gap = 0.0004;                ///< a finger stops this far off the object ...
  double gap_tolerance = 0.0002;              ///< ... or at most so much before
  double contact_range = 0.002;               ///< finger links nearer than this are contacts
  double opposing_range = 0.001;              ///< of the two contacts that oppose
  double opposing_angle = 2.268928027592628;  ///< 130 deg; the contract asks for 120
  double retreat = 0.10;                      ///< length of the straight approach
};

/// The object at the origin of the world, the hand anywhere. Not thread-safe; deterministic.
class FingerClosing {
 public:
  FingerClosing(const SceneObject& object, HandModel hand, const GraspRules& rules);
  FingerClosing(const FingerClosing&) = delete;
  FingerClosing& operator=(const FingerClosing&) = delete;

  const HandModel& hand() const { return hand_; }

  /// The finger that a link belongs to, an index in Hand::fingers; -1: none.
  int fingerOf(const std::string& link) const;

  /// How far apart two finger links that closing brings nearer are at most with the hand open [m].
  double opening();

  /// How far the hand can come along its approach from `far` [m] back to `near`, nothing of it
  /// nearer to the object than the clearance: the least offset back from X_OT reached. nullopt: not
  /// free at `far`.
  std::optional<double> advance(const Pose& X_OT, const Eigen::VectorXd& q, double far,
                                double near);

  /// Closes the fingers one after the other, each from the palm outwards, every joint until what it
  /// moves is at the object, or near another part of the hand, or at its closing end.
  Eigen::VectorXd close(const Pose& X_OT, const Eigen::VectorXd& open);

  /// Contacts of finger links; empty unless two oppose, by the grip rule too, and nothing else of
  /// the hand is near the object.
  std::vector<GraspContact> contacts(const Pose& X_OT, const Eigen::VectorXd& closed);

  /// The least opening on the straight line from `closed` to `open` with which the hand can come
  /// along the approach, provided the fingers can travel that line without touching more than the
  /// object's skin. nullopt: none.
  std::optional<Eigen::VectorXd> leastOpening(const Pose& X_OT, const Eigen::VectorXd& closed,
                                              const Eigen::VectorXd& open);

 private:
  struct Mover {
    LinkId link;
    BodyId body;
    double reach = 0;  // greatest speed of a point of the link per unit of the dof
  };

  struct SelfPair {
    BodyId a, b;
    LinkId link_a, link_b;
    double needed = 0;
  };

  /// Of every two finger links at a posture [m], at most kWidest.
  std::vector<double> fingersApart(const Eigen::VectorXd& q);
  /// Of the constructor.
  void guardSelfPairs();
  void addMovers(DofId dof);

  void set(const Pose& X_OT, const Eigen::VectorXd& q);
  /// Of the part of the hand nearest to the object's convex parts, at most `max`; any part's below
  /// `enough` will do.
  double handToParts(double max, double enough);
  /// The same to the object's own surface, and only what is below 2 mm is exact: of what is farther
  /// it may be too little.
  double handToSurface(double max, double enough);
  template <typename Distance>
  double handTo(double max, double enough, const Distance& distance);
  /// Distance of a link with shapes to the object's own surface, up to `max`: as handToSurface().
  std::optional<BodyDistance> toSurface(LinkId link, double max);
  void closeJoint(const Pose& X_OT, int dof, Eigen::VectorXd& q);
  /// How much a joint may still move before anything it moves could touch. 0: it is there.
  double freeTravel(int dof);
  bool lineIsFree(const Pose& X_OT, const Eigen::VectorXd& from, const Eigen::VectorXd& to);

  HandModel hand_;
  GraspRules rules_;
  ObjectSurface surface_;
  GripRule grip_;
  bool divided_;  ///< the object or a link of the hand: its parts are not its surface
  SurfaceTree object_parts_;
  std::vector<SurfaceTree> link_parts_;  // by link
  CollisionWorld world_;
  BodyId object_;
  std::vector<BodyId> link_body_;               // by link
  std::vector<LinkId> links_;                   // of the hand, that have shapes
  std::vector<bool> is_finger_;                 // by link
  std::vector<int> finger_;                     // by link: the first of Hand::fingers that moves it
  std::vector<std::vector<Mover>> movers_;      // by hand dof
  std::vector<std::vector<SelfPair>> guarded_;  // by hand dof: pairs whose distance it changes
  std::vector<SelfPair> self_pairs_;
  std::vector<Pose> X_WL_;
};

/// How far apart the fingers of an arm's hand are at most with the hand open [m]; 0: it has fewer
/// than two. @throws std::invalid_argument as extractEndEffector().
double handOpening(const RobotModel& model, ArmId arm);

}  // namespace handover
