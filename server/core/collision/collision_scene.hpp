// SPDX-License-Identifier: Apache-2.0
// Collision over a scene: an immutable snapshot per scene revision, and a cheap instance per
// worker.
#pragma once

#include "core/collision/rigid_groups.hpp"
#include "core/model/id.hpp"
#include "core/model/scene.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover {

/// A robot's link with shapes, or an object. Dense from 0: the robots' links in order, then the
/// objects.
using BodyId = Id<struct BodyTag>;

using BodyPair = std::pair<BodyId, BodyId>;

struct BodyContact {
  BodyId a, b;
  double depth = 0;  ///< [m], > 0: the shapes overlap by this; in [-2 mm, 0]: only their margins do
};

/// Closest points of two bodies; of overlapping ones, the points that are deepest in each other.
struct BodyDistance {
  double distance = 0;  ///< [m]; < 0: they overlap, by the least move that would part them
  Eigen::Vector3d p_Wa, p_Wb;
  Eigen::Vector3d n_W;  ///< unit, from b towards a: b's outward normal at the contact
};

/// A symmetric set of body pairs.
class BodyPairs {
 public:
  explicit BodyPairs(int bodies)
      : bodies_(bodies),
        bits_(static_cast<std::size_t>(bodies) * static_cast<std::size_t>(bodies)) {}

  void insert(BodyId a, BodyId b) { bits_[at(a, b)] = bits_[at(b, a)] = true; }

  /// Every pair of one of `as` with one of `bs`; invalid ids (of links without shapes) are passed
  /// over.
  void insert(const std::vector<BodyId>& as, const std::vector<BodyId>& bs);

  void erase(BodyId a, BodyId b) { bits_[at(a, b)] = bits_[at(b, a)] = false; }

  bool contains(BodyId a, BodyId b) const { return bits_[at(a, b)]; }

  int bodies() const { return bodies_; }

 private:
  std::size_t at(BodyId a, BodyId b) const {
    return std::size_t{a} * static_cast<std::size_t>(bodies_) + std::size_t{b};
  }

  int bodies_;
  std::vector<bool> bits_;
};

/// Immutable; safe from any thread. Shapes carry 1 mm of margin, so pairs nearer than 2 mm count as
/// contacts: Bullet misses true overlaps without, and everything that is reported is within 3 mm.
class CollisionScene {
 public:
  /// @throws std::invalid_argument for poses or sizes that are not finite, names that do not exist.
  explicit CollisionScene(const Scene& scene);
  ~CollisionScene();

  int bodies() const;
  /// `robot/link` or the object's name.
  const std::string& name(BodyId body) const;
  /// Invalid where the link has no shapes.
  BodyId linkBody(RobotId robot, LinkId link) const;
  /// Bodies of those links that have shapes, in the order given.
  std::vector<BodyId> linkBodies(RobotId robot, const std::vector<LinkId>& links) const;
  BodyId objectBody(ObjectId object) const;
  /// The robot whose link the body is; none: it is an object.
  RobotId robotOf(BodyId body) const;
  /// Pairs never tested (design §5): links joined by a joint, through fixed ones too; SRDF pairs
  /// with reason Adjacent or Always; `attached_to` with its touch_links; resting pairs.
  const BodyPairs& standingPairs() const;

  struct Data;

  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<const Data> data_;
};

/// A fixed list of pairs to test, compiled once and used for many states. Immutable.
class PairList {
 public:
  PairList() = default;
  explicit PairList(std::vector<std::pair<BodyId, BodyId>> pairs);

  const std::vector<std::pair<BodyId, BodyId>>& pairs() const { return pairs_; }

  // The first bodies of the pairs, in groups of at most 64, and for every second body the ones that
  // it is paired with: its box is tested against all of them at once.
  struct Row {
    int group;
    BodyId other;
    std::uint64_t movers;  ///< bit i: paired with the group's i-th body
  };

  /// The same pairs, by group; in each, objects before links.
  const std::vector<Row>& rows() const { return rows_; }

  template <typename Visit>
  void forEachMover(const Row& row, const Visit& visit) const {
    if (row.movers == 0) return;
    const std::vector<BodyId>& movers = movers_[static_cast<std::size_t>(row.group)];
    for (std::uint64_t bits = row.movers; bits != 0; bits &= bits - 1) {
      visit(movers[static_cast<std::size_t>(std::countr_zero(bits))], bits & -bits);
    }
  }

 private:
  friend class CollisionWorld;

  std::vector<std::pair<BodyId, BodyId>> pairs_;
  std::vector<std::vector<BodyId>> movers_;  ///< by group
  std::vector<Row> rows_;
};

/// A body that moves with a group of the moving robot.
struct MovingBody {
  BodyId body;
  int group = -1;
  Pose X_GB = Pose::Identity();  ///< of the body in the group
};

/// How far apart shapes are to be on a motion [m], their margins taken off. No pair is looked at
/// more often than its bodies travel twice the difference.
struct Clearance {
  double looked;  ///< wherever the motion is looked at: nearer is a contact
  double proven;  ///< all along it; less
};

/// Of ways that are planned, and of the same ways once they are timed: what was proven of the first
/// is enough for the second, whose corners are rounded.
inline constexpr Clearance kPlannedClearance{0.002, 0.001}, kTimedClearance{0.001, 0.0005};
static_assert(kTimedClearance.looked <= kPlannedClearance.proven);

/// How far bodies may still travel from where they stand: those of groups that were just given
/// bounds.
class BodyTravel {
 public:
  /// @param index  in `moving`, by body; -1: stands still
  BodyTravel(const RigidGroups& groups, const std::vector<MovingBody>& moving,
             const std::vector<int>& index)
      : groups_(groups), moving_(moving), index_(index) {}

  /// In the world [m].
  double of(BodyId body) const { return groups_.travel(groupOf(body)); }

  /// Against each other.
  PairMotion approach(BodyId a, BodyId b) const { return groups_.approach(groupOf(a), groupOf(b)); }

 private:
  int groupOf(BodyId body) const {
    const int i = index_[body];
    return i < 0 ? -1 : moving_[static_cast<std::size_t>(i)].group;
  }

  const RigidGroups& groups_;
  const std::vector<MovingBody>& moving_;
  const std::vector<int>& index_;
};

/// One worker's collision world over a CollisionScene: body poses that can be set, Bullet's
/// verdicts. Verdicts are functions of the poses alone. Not thread-safe; make one per worker.
class CollisionWorld {
 public:
  explicit CollisionWorld(std::shared_ptr<const CollisionScene> scene);
  ~CollisionWorld();
  CollisionWorld(CollisionWorld&&) noexcept;

  const CollisionScene& scene() const;

  /// Everything as in the scene: robots at q_start, objects at their poses.
  void reset();
  /// @throws std::invalid_argument when the pose is not finite.
  void setPose(BodyId body, const Pose& X_WBody);
  const Pose& pose(BodyId body) const;
  /// Sets the poses of all links of a robot (X_WL by link index, from linkPoses()), and of the
  /// objects that the scene attaches to one of them.
  void setRobot(RobotId robot, const std::vector<Pose>& X_WL);
  /// Rises with every pose that becomes another: tells whether somebody has moved anything since.
  std::uint64_t changes() const;

  /// Pairs of (a body in `moving`) with (any body), less `allowed`, less the standing pairs and
  /// less pairs within a rigid group (bodies of the same group number >= 0 in `rigid_group`, by
  /// body, move as one and are not tested).
  PairList makePairs(const std::vector<BodyId>& moving, const BodyPairs& allowed,
                     const std::vector<int>& rigid_group = {}) const;

  /// True when no pair of the list touches (margins included). The first pair found goes to `hit`.
  bool isFree(const PairList& pairs, BodyContact* hit = nullptr);
  /// The first touching pair of some rows of a list.
  std::optional<BodyPair> touchingPair(const PairList& pairs,
                                       const std::vector<PairList::Row>& rows);
  /// The same while the bodies travel: false when a pair of `rows` is nearer than
  /// `clearance.looked` as they stand (it goes to `hit`). Of the others, those that are not proven
  /// to stay apart by `clearance.proven` go to `undecided`.
  /// @param rows  of `pairs`, or what an earlier call left undecided.
  bool staysFree(const PairList& pairs, const PairList::Row* rows, std::size_t count,
                 const BodyTravel& travel, const Clearance& clearance,
                 std::vector<PairList::Row>& undecided, BodyContact* hit = nullptr);

  /// Every touching pair of the list, with depth.
  std::vector<BodyContact> contacts(const PairList& pairs);
  /// Distance of two bodies up to `max_distance`; nullopt if they are farther apart. Margins taken
  /// off: the distance of the shapes themselves, positive when apart.
  std::optional<BodyDistance> distance(BodyId a, BodyId b, double max_distance);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace handover
