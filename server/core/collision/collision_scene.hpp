// SPDX-License-Identifier: Apache-2.0
// Collision over a scene: an immutable snapshot per scene revision, and a cheap instance per worker.
#pragma once

#include "core/model/scene.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover {

/// A robot's link with shapes, or an object. Dense from 0.
using BodyId = int;

struct BodyContact {
  BodyId a = -1, b = -1;
  double depth = 0;          ///< [m], > 0: the bodies overlap by this, less the margins
};

/// Closest points of two bodies.
struct BodyDistance {
  double distance = 0;       ///< [m]; <= 0: they touch or overlap
  Eigen::Vector3d p_Wa, p_Wb;
  Eigen::Vector3d n_W;       ///< unit, from b towards a: b's outward normal at the contact
};

/// A symmetric set of body pairs.
class BodyPairs {
 public:
  explicit BodyPairs(int bodies) : bodies_(bodies), bits_(static_cast<std::size_t>(bodies) * static_cast<std::size_t>(bodies)) {}
  void insert(BodyId a, BodyId b) { bits_[at(a, b)] = bits_[at(b, a)] = true; }
  void erase(BodyId a, BodyId b) { bits_[at(a, b)] = bits_[at(b, a)] = false; }
  bool contains(BodyId a, BodyId b) const { return bits_[at(a, b)]; }
  int bodies() const { return bodies_; }

 private:
  std::size_t at(BodyId a, BodyId b) const {
    return static_cast<std::size_t>(a) * static_cast<std::size_t>(bodies_) + static_cast<std::size_t>(b);
  }
  int bodies_;
  std::vector<bool> bits_;
};

/// Immutable; safe from any thread. Shapes carry 1 mm of margin, so pairs nearer than about 2 mm
/// count as contacts (design §7, reference measurements).
class CollisionScene {
 public:
  explicit CollisionScene(const Scene& scene);
  ~CollisionScene();

  int bodies() const;
  /// `robot/link` or the object's name.
  const std::string& name(BodyId body) const;
  /// -1 where the link has no shapes.
  BodyId linkBody(int robot, int link) const;
  BodyId objectBody(int object) const;
  /// Pairs never tested (design §5): links joined by a joint, through fixed ones too; SRDF pairs with
  /// reason Adjacent or Always; `attached_to` with its touch_links; resting pairs.
  const BodyPairs& standingPairs() const;

  struct Data;
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<const Data> data_;
};

/// A fixed list of pairs to test, compiled once and used for many states.
struct PairList {
  std::vector<std::pair<BodyId, BodyId>> pairs;
};

/// One worker's collision world over a CollisionScene: body poses that can be set, Bullet's verdicts.
/// Not thread-safe; make one per worker. Copying poses between instances is not needed: set them.
class CollisionWorld {
 public:
  explicit CollisionWorld(std::shared_ptr<const CollisionScene> scene);
  ~CollisionWorld();
  CollisionWorld(CollisionWorld&&) noexcept;

  const CollisionScene& scene() const;

  /// Everything as in the scene: robots at q_start, objects at their poses.
  void reset();
  void setPose(BodyId body, const Pose& X_WBody);
  const Pose& pose(BodyId body) const;
  /// Sets the poses of all links of a robot (X_WL by link index, from linkPoses()).
  void setRobot(int robot, const std::vector<Pose>& X_WL);

  /// Pairs of (a body in `moving`) with (any body), less `allowed` and less pairs within a rigid group
  /// (bodies of the same group number >= 0 in `rigid_group` move as one and are not tested).
  PairList makePairs(const std::vector<BodyId>& moving, const BodyPairs& allowed,
                     const std::vector<int>& rigid_group = {}) const;

  /// True when no pair of the list touches (margins included). The first pair found goes to `hit`.
  bool isFree(const PairList& pairs, BodyContact* hit = nullptr);
  /// Every touching pair of the list, with depth.
  std::vector<BodyContact> contacts(const PairList& pairs);
  /// Distance of two bodies up to `max_distance`; nullopt if they are farther apart. Margins taken off:
  /// the distance of the shapes themselves, positive when apart.
  std::optional<BodyDistance> distance(BodyId a, BodyId b, double max_distance);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
