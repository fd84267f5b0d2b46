// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/map_file.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace handover {
namespace {

/// Feeds whole numbers and lengths rounded to 1e-9: sines of other libraries differ in the last
/// bit.
class Hasher {
 public:
  Hasher() : state_(XXH3_createState(), &XXH3_freeState) {
    if (!state_) throw std::bad_alloc();
    XXH3_64bits_reset(state_.get());
  }

  void add(std::int64_t number) { XXH3_64bits_update(state_.get(), &number, sizeof(number)); }

  template <class Tag>
  void add(Id<Tag> id) {
    add(std::int64_t{id.value()});
  }

  void add(double number) {
    constexpr double kMost = 9e9;  // beyond this (and for NaN) the bits themselves
    if (std::abs(number) < kMost) {
      add(static_cast<std::int64_t>(std::llround(number * 1e9)));
    } else {
      add(std::bit_cast<std::int64_t>(number));
    }
  }

  void add(const Eigen::Vector3d& v) {
    for (const double x : v) add(x);
  }

  void add(const Pose& X) {
    for (int column = 0; column < 4; ++column)
      add(Eigen::Vector3d(X.matrix().col(column).head<3>()));
  }

  void add(const Shape& shape) {
    add(shape.X_BS);
    add(static_cast<std::int64_t>(shape.geometry.index()));
    std::visit([this](const auto& geometry) { addGeometry(geometry); }, shape.geometry);
  }

  std::uint64_t digest() const { return XXH3_64bits_digest(state_.get()); }

 private:
  void addGeometry(const BoxShape& box) { add(box.size); }

  void addGeometry(const SphereShape& sphere) { add(sphere.radius); }

  void addGeometry(const CylinderShape& cylinder) {
    add(cylinder.radius);
    add(cylinder.length);
  }

  void addGeometry(const ConvexShape& hull) {
    add(static_cast<std::int64_t>(hull.vertices.size()));
    for (const Eigen::Vector3d& vertex : hull.vertices) add(vertex);
  }

  std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state_;
};

bool contains(const std::vector<JointId>& list, JointId value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

/// Where a joint stands while the arm is sampled: the arm's own fingers open, all else as in
/// q_torso.
double standingPosition(const RobotModel& model, const Arm& arm, const Joint& joint,
                        const RobotVector& q_torso) {
  double position = q_torso[joint.dof.value()];
  if (arm.hand.valid()) {
    const Hand& hand = model.hands.at(arm.hand);
    const auto at = std::find(hand.dofs.begin(), hand.dofs.end(), joint.dof);
    if (at != hand.dofs.end()) position = hand.open[at - hand.dofs.begin()];
  }
  return joint.mimic ? joint.mimic_multiplier * position + joint.mimic_offset : position;
}

/// The links that are this arm, carry it or stand still beside it: all but the other arms'.
std::vector<bool> linksThatCount(const RobotModel& model, const Arm& arm) {
  std::vector<bool> counts(model.links.size(), true);
  for (const Joint& joint : model.joints) {
    const JointId index(&joint - model.joints.data());
    const bool others = std::any_of(model.arms.begin(), model.arms.end(), [&](const Arm& other) {
      return contains(other.joints, index) && !contains(arm.joints, index);
    });
    counts[joint.child_link] = counts[joint.parent_link] && !others;
  }
  return counts;
}

/// All that decides what one arm reaches.
void addArm(const RobotModel& model, const Arm& arm, const RobotVector& q_torso, Hasher& hasher) {
  hasher.add(arm.base_link);
  hasher.add(arm.tool_link);
  hasher.add(arm.approach_axis);

  const std::vector<bool> counts = linksThatCount(model, arm);
  for (const JointId j : IdRange<JointId>(model.joints.size())) {
    const Joint& joint = model.joints[j];
    if (!counts[joint.child_link]) continue;
    hasher.add(joint.parent_link);
    hasher.add(joint.child_link);
    hasher.add(static_cast<std::int64_t>(joint.type));
    hasher.add(joint.X_PJ);
    if (joint.type == JointType::kFixed) continue;
    hasher.add(joint.axis);
    if (contains(arm.joints, j)) {
      hasher.add(joint.lower);
      hasher.add(joint.upper);
    } else {
      hasher.add(standingPosition(model, arm, joint, q_torso));
    }
  }
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    if (!counts[link]) continue;
    hasher.add(static_cast<std::int64_t>(link));
    hasher.add(static_cast<std::int64_t>(model.links[link].collision.size()));
    for (const Shape& shape : model.links[link].collision) hasher.add(shape);
  }
  for (const auto& [pair, reason] : model.disabled_pairs) {
    if (!counts[pair.first] || !counts[pair.second]) continue;
    hasher.add(pair.first);
    hasher.add(pair.second);
  }
}

}  // namespace

std::uint64_t ReachabilityMap::hash(const RobotModel& model, ArmId arm, const RobotVector& q_torso,
                                    const ReachabilityParams& params) {
  if (q_torso.size() != model.dofs()) {
    throw std::invalid_argument("a robot of " + std::to_string(model.dofs()) +
                                " joints was given " + std::to_string(q_torso.size()) +
                                " positions");
  }
  Hasher hasher;
  hasher.add(std::int64_t{reachability::kFileVersion});
  hasher.add(params.voxel);
  hasher.add(static_cast<std::int64_t>(params.samples));
  hasher.add(static_cast<std::int64_t>(params.seed));
  hasher.add(static_cast<std::int64_t>(params.tie_samples));
  hasher.add(params.tie_errors);
  hasher.add(arm);
  for (const Arm& each : model.arms) addArm(model, each, q_torso, hasher);
  return hasher.digest();
}

}  // namespace handover
