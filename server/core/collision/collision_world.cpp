// SPDX-License-Identifier: Apache-2.0
#include "core/collision/box.hpp"
#include "core/collision/collision_scene.hpp"
#include "core/collision/scene_data.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace handover {
namespace {

// Bodies that travel farther than this [m] are nearly always too near to others for a proof that
// they stay apart: such a stretch of a motion is divided first.
constexpr double kFarTravel = 0.12;

// An Aabb in single precision, rounded outwards: small enough to test many at once.
struct FloatBox {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  std::array<float, 3> lower{kInfinity, kInfinity, kInfinity};
  std::array<float, 3> upper{-kInfinity, -kInfinity, -kInfinity};

  FloatBox() = default;

  explicit FloatBox(const Aabb& box) {
    if (box.lower.x() > box.upper.x()) return;  // no shapes, no box
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const double least = box.lower[axis], most = box.upper[axis];
      lower[i] = static_cast<float>(least - 1e-6 * (1 + std::abs(least)));
      upper[i] = static_cast<float>(most + 1e-6 * (1 + std::abs(most)));
    }
  }

  void grow(double by) {
    const auto more = static_cast<float>(by * (1 + 1e-6));
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] -= more;
      upper[i] += more;
    }
  }

  void add(const FloatBox& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], other.lower[i]);
      upper[i] = std::max(upper[i], other.upper[i]);
    }
  }
};

bool overlap(const FloatBox& a, const FloatBox& b) {
  bool meet = true;
  for (std::size_t i = 0; i < 3; ++i) {
    meet &= a.lower[i] <= b.upper[i] && b.lower[i] <= a.upper[i];
  }
  return meet;
}

// Up to 64 boxes side by side, tested against one other four at a time.
class BoxRow {
 public:
  static constexpr std::size_t kSize = 64;

  void clear() { count_ = 0; }

  /// Those in between that are not set mean nothing.
  void set(std::size_t i, const FloatBox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower_[axis][i] = box.lower[axis];
      upper_[axis][i] = box.upper[axis];
    }
    count_ = std::max(count_, i + 1);
  }

  /// Bit i: the i-th box overlaps `box`. Bits beyond the boxes pushed mean nothing.
  std::uint64_t overlapping(const FloatBox& box) const {
    std::uint64_t bits = 0;
#ifdef __SSE2__
    for (std::size_t i = 0; i < count_; i += 4) {
      __m128 meet = _mm_castsi128_ps(_mm_set1_epi32(-1));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const __m128 lower = _mm_load_ps(&lower_[axis][i]), upper = _mm_load_ps(&upper_[axis][i]);
        meet = _mm_and_ps(meet, _mm_cmple_ps(lower, _mm_set1_ps(box.upper[axis])));
        meet = _mm_and_ps(meet, _mm_cmple_ps(_mm_set1_ps(box.lower[axis]), upper));
      }
      bits |= static_cast<std::uint64_t>(_mm_movemask_ps(meet)) << i;
    }
#else
    for (std::size_t i = 0; i < count_; ++i) {
      bool meet = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        meet &= lower_[axis][i] <= box.upper[axis] && box.lower[axis] <= upper_[axis][i];
      }
      bits |= static_cast<std::uint64_t>(meet) << i;
    }
#endif
    return bits;
  }

 private:
  alignas(16) std::array<std::array<float, kSize>, 3> lower_{}, upper_{};
  std::size_t count_ = 0;
};

/// What of a clearance two boxes with their margins do not hold.
double beyondMargins(double clearance) { return std::max(0.0, clearance - 2 * kCollisionMargin); }

double squaredMiddles(const Aabb& a, const Aabb& b) {
  return 0.25 * (a.lower + a.upper - b.lower - b.upper).squaredNorm();
}

}  // namespace

PairList::PairList(std::vector<std::pair<BodyId, BodyId>> pairs) : pairs_(std::move(pairs)) {
  std::vector<BodyId> movers;
  BodyId last;
  for (const auto& [a, b] : pairs_) {
    if (std::find(movers.begin(), movers.end(), a) == movers.end()) movers.push_back(a);
    last = std::max({last, a, b});
  }
  const auto bodies = static_cast<std::size_t>(last.value() + 1);
  std::vector<std::size_t> place(bodies);
  for (std::size_t i = 0; i < movers.size(); ++i) {
    if (i % BoxRow::kSize == 0) movers_.emplace_back();
    movers_.back().push_back(movers[i]);
    place[movers[i]] = i;
  }
  std::vector<std::uint64_t> masks(movers_.size() * bodies);
  for (const auto& [a, b] : pairs_) {
    const std::size_t at = place[a];
    masks[at / BoxRow::kSize * bodies + std::size_t{b}] |= std::uint64_t{1} << (at % BoxRow::kSize);
  }
  for (std::size_t g = 0; g < movers_.size(); ++g) {
    for (std::size_t b = bodies; b-- > 0;) {
      const std::uint64_t mask = masks[g * bodies + b];
      if (mask != 0) rows_.push_back({static_cast<int>(g), BodyId(b), mask});
    }
  }
}

struct CollisionWorld::Data {
  static Pose nowhere() {
    Pose X;
    X.matrix().setConstant(std::numeric_limits<double>::quiet_NaN());
    return X;
  }

  explicit Data(std::shared_ptr<const CollisionScene> of)
      : scene(std::move(of)),
        poses(scene->data().names.size(), nowhere()),
        body_boxes(scene->data().names.size()),
        shape_boxes(scene->data().shapes.size()) {}

  std::shared_ptr<const CollisionScene> scene;
  std::vector<Pose> poses;
  std::vector<FloatBox> body_boxes;
  BoxRow mover_boxes, travel_boxes;  ///< scratch of isFree() and staysFree()
  std::vector<Aabb> shape_boxes;
  std::vector<Pose> X_WL;  ///< scratch of reset()
  std::uint64_t changes = 0;

  const SceneShape& shape(int index) const {
    return scene->data().shapes[static_cast<std::size_t>(index)];
  }

  const Aabb& shapeBox(int index) const { return shape_boxes[static_cast<std::size_t>(index)]; }

  int firstShape(BodyId body) const { return scene->data().first_shape[body]; }

  /// One past the last.
  int endShape(BodyId body) const { return scene->data().first_shape[std::size_t{body} + 1]; }

  bool boxesOverlap(BodyId a, BodyId b) const { return overlap(body_boxes[a], body_boxes[b]); }

  Pose shapePose(BodyId body, int index) const { return poses[body] * shape(index).X_BS; }

  /// Nearer than `gap`.
  bool bodiesTouch(BodyId a, BodyId b, double gap = 2 * kCollisionMargin) const;
  Nearness bodiesNearness(BodyId a, BodyId b, const PairMotion& motion,
                          const Clearance& clearance) const;
  std::optional<BodyDistance> bodyDistance(BodyId a, BodyId b, double max_distance) const;
  BodyContact contact(BodyId a, BodyId b) const;
};

bool CollisionWorld::Data::bodiesTouch(BodyId a, BodyId b, double gap) const {
  const double beyond = beyondMargins(gap);
  for (int i = firstShape(a); i < endShape(a); ++i) {
    for (int j = firstShape(b); j < endShape(b); ++j) {
      if (squaredGap(shapeBox(i), shapeBox(j)) > beyond * beyond) continue;
      if (touching(shape(i).narrow, shapePose(a, i), shape(j).narrow, shapePose(b, j), gap)) {
        return true;
      }
    }
  }
  return false;
}

Nearness CollisionWorld::Data::bodiesNearness(BodyId a, BodyId b, const PairMotion& motion,
                                              const Clearance& clearance) const {
  Nearness nearest = Nearness::kApart;
  const double reach = motion.most + beyondMargins(clearance.looked);
  for (int i = firstShape(a); i < endShape(a); ++i) {
    for (int j = firstShape(b); j < endShape(b); ++j) {
      const double squared_gap = squaredGap(shapeBox(i), shapeBox(j));
      if (squared_gap > reach * reach) continue;
      // Apart as they stand; so near, measured by the travel, that a proof is out of the question.
      if (squared_gap > 0 &&
          squaredMiddles(shapeBox(i), shapeBox(j)) <= motion.beyond * motion.beyond) {
        nearest = Nearness::kNear;
        continue;
      }
      const Nearness found = nearness(shape(i).narrow, shapePose(a, i), shape(j).narrow,
                                      shapePose(b, j), motion, clearance.looked, clearance.proven);
      if (found == Nearness::kTouching) return found;
      if (found == Nearness::kNear) nearest = found;
    }
  }
  return nearest;
}

std::optional<BodyDistance> CollisionWorld::Data::bodyDistance(BodyId a, BodyId b,
                                                               double max_distance) const {
  std::optional<BodyDistance> best;
  double limit = max_distance;
  for (int i = firstShape(a); i < endShape(a); ++i) {
    for (int j = firstShape(b); j < endShape(b); ++j) {
      // The boxes include the margins, so their gap is smaller than that of the shapes: safe.
      if (limit >= 0 && squaredGap(shapeBox(i), shapeBox(j)) > limit * limit) continue;
      if (limit < 0 && !overlap(shapeBox(i), shapeBox(j))) continue;
      const ShapeDistance found =
          shapeDistance(shape(i).narrow, shapePose(a, i), shape(j).narrow, shapePose(b, j));
      if (found.distance > limit) continue;
      limit = found.distance;
      best = BodyDistance{found.distance, found.p_Wa, found.p_Wb, found.n_W};
    }
  }
  return best;
}

BodyContact CollisionWorld::Data::contact(BodyId a, BodyId b) const {
  const auto found = bodyDistance(a, b, 3 * kCollisionMargin);
  return {a, b, found ? -found->distance : 0};
}

CollisionWorld::CollisionWorld(std::shared_ptr<const CollisionScene> scene)
    : data_(std::make_unique<Data>(std::move(scene))) {
  reset();
}

CollisionWorld::~CollisionWorld() = default;
CollisionWorld::CollisionWorld(CollisionWorld&&) noexcept = default;

const CollisionScene& CollisionWorld::scene() const { return *data_->scene; }

void CollisionWorld::reset() {
  const CollisionScene::Data& scene = data_->scene->data();
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    setPose(scene.object_bodies[o], scene.objects[o].X_WO);
  }
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    const SceneRobot& robot = scene.robots[r];
    linkPoses(*robot.model, robot.X_WB, robot.q_start, data_->X_WL);
    setRobot(RobotId(r), data_->X_WL);
  }
}

void CollisionWorld::setPose(BodyId body, const Pose& X_WBody) {
  if (data_->poses[body].matrix() == X_WBody.matrix()) return;
  if (!X_WBody.matrix().allFinite()) {
    throw std::invalid_argument("pose of " + data_->scene->name(body) + " is not finite");
  }
  data_->poses[body] = X_WBody;
  Aabb whole;
  for (int i = data_->firstShape(body); i < data_->endShape(body); ++i) {
    const Aabb box = worldBox(X_WBody, data_->shape(i));
    data_->shape_boxes[static_cast<std::size_t>(i)] = box;
    whole.add(box);
  }
  data_->body_boxes[body] = FloatBox(whole);
  ++data_->changes;
}

std::uint64_t CollisionWorld::changes() const { return data_->changes; }

const Pose& CollisionWorld::pose(BodyId body) const { return data_->poses.at(body); }

void CollisionWorld::setRobot(RobotId robot, const std::vector<Pose>& X_WL) {
  const CollisionScene::Data& scene = data_->scene->data();
  const std::vector<BodyId>& bodies = scene.link_bodies.at(robot);
  if (X_WL.size() != bodies.size()) throw std::invalid_argument("setRobot: one pose per link");
  for (std::size_t l = 0; l < bodies.size(); ++l) {
    if (bodies[l].valid()) setPose(bodies[l], X_WL[l]);
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const std::optional<Attachment>& attached = scene.objects[o].attached_to;
    if (!attached || attached->robot != robot) continue;
    setPose(scene.object_bodies[o], X_WL[attached->link] * attached->X_LO);
  }
}

PairList CollisionWorld::makePairs(const std::vector<BodyId>& moving, const BodyPairs& allowed,
                                   const std::vector<int>& rigid_group) const {
  const CollisionScene& scene = *data_->scene;
  const auto group = [&](BodyId body) {
    return std::size_t{body} < rigid_group.size() ? rigid_group[body] : -1;
  };
  std::vector<bool> done(static_cast<std::size_t>(scene.bodies()));
  std::vector<std::pair<BodyId, BodyId>> pairs;
  for (BodyId a : moving) {
    if (!a.valid() || done[a]) continue;
    done[a] = true;
    for (const BodyId b : IdRange<BodyId>(scene.bodies())) {
      if (done[b]) continue;
      if (allowed.contains(a, b) || scene.standingPairs().contains(a, b)) continue;
      if (group(a) >= 0 && group(a) == group(b)) continue;
      pairs.emplace_back(a, b);
    }
  }
  return PairList(std::move(pairs));
}

bool CollisionWorld::isFree(const PairList& pairs, BodyContact* hit) {
  const auto touching = touchingPair(pairs, pairs.rows_);
  if (touching && hit) *hit = data_->contact(touching->first, touching->second);
  return !touching;
}

std::optional<BodyPair> CollisionWorld::touchingPair(const PairList& pairs,
                                                     const std::vector<PairList::Row>& rows) {
  FloatBox whole;
  int group = -1;
  for (const PairList::Row& row : rows) {
    const std::vector<BodyId>& movers = pairs.movers_[static_cast<std::size_t>(row.group)];
    if (row.group != group) {
      group = row.group;
      whole = {};
      data_->mover_boxes.clear();
      for (std::size_t i = 0; i < movers.size(); ++i) {
        const FloatBox& box = data_->body_boxes[movers[i]];
        whole.add(box);
        data_->mover_boxes.set(i, box);
      }
    }
    const FloatBox& box = data_->body_boxes[row.other];
    if (!overlap(whole, box)) continue;
    std::uint64_t near = data_->mover_boxes.overlapping(box) & row.movers;
    for (; near != 0; near &= near - 1) {
      const BodyId mover = movers[static_cast<std::size_t>(std::countr_zero(near))];
      if (data_->bodiesTouch(mover, row.other)) return BodyPair{mover, row.other};
    }
  }
  return std::nullopt;
}

bool CollisionWorld::staysFree(const PairList& pairs, const PairList::Row* rows, std::size_t count,
                               const BodyTravel& travel, const Clearance& clearance,
                               std::vector<PairList::Row>& undecided, BodyContact* hit) {
  // The boxes hold both margins, which make up for as much of the clearance.
  const double beyond = beyondMargins(clearance.looked);
  FloatBox whole;
  bool far = false;
  for (std::size_t r = 0; r < count; ++r) {
    const PairList::Row& row = rows[r];
    const std::vector<BodyId>& movers = pairs.movers_[static_cast<std::size_t>(row.group)];
    if (r == 0 || row.group != rows[r - 1].group) {
      std::uint64_t wanted = 0;
      for (std::size_t i = r; i < count && rows[i].group == row.group; ++i) {
        wanted |= rows[i].movers;
      }
      whole = {};
      data_->mover_boxes.clear();
      data_->travel_boxes.clear();
      double most = 0;
      for (; wanted != 0; wanted &= wanted - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(wanted));
        FloatBox box = data_->body_boxes[movers[i]];
        if (beyond > 0) box.grow(beyond);
        data_->mover_boxes.set(i, box);
        const double way = travel.of(movers[i]);
        box.grow(way);
        most = std::max(most, way);
        whole.add(box);
        data_->travel_boxes.set(i, box);
      }
      far = most > kFarTravel;
    }
    const FloatBox& box = data_->body_boxes[row.other];
    FloatBox grown = box;
    grown.grow(travel.of(row.other));
    if (!overlap(whole, grown)) continue;
    PairList::Row left{row.group, row.other, 0};
    std::uint64_t near = data_->travel_boxes.overlapping(grown) & row.movers;
    if (far) {  // too far for proofs: only what touches as it stands is sought
      left.movers = near;
      near &= data_->mover_boxes.overlapping(box);
    }
    for (; near != 0; near &= near - 1) {
      const std::uint64_t bit = near & -near;
      const BodyId mover = movers[static_cast<std::size_t>(std::countr_zero(near))];
      const Nearness found =
          far ? (data_->bodiesTouch(mover, row.other, clearance.looked) ? Nearness::kTouching
                                                                        : Nearness::kNear)
              : data_->bodiesNearness(mover, row.other, travel.approach(mover, row.other),
                                      clearance);
      if (found == Nearness::kTouching) {
        if (hit) *hit = data_->contact(mover, row.other);
        return false;
      }
      if (found == Nearness::kNear) left.movers |= bit;
    }
    if (left.movers != 0) undecided.push_back(left);
  }
  return true;
}

std::vector<BodyContact> CollisionWorld::contacts(const PairList& pairs) {
  std::vector<BodyContact> found;
  for (const auto& [a, b] : pairs.pairs()) {
    if (!data_->boxesOverlap(a, b) || !data_->bodiesTouch(a, b)) continue;
    found.push_back(data_->contact(a, b));
  }
  return found;
}

std::optional<BodyDistance> CollisionWorld::distance(BodyId a, BodyId b, double max_distance) {
  return data_->bodyDistance(a, b, max_distance);
}

}  // namespace handover
