// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/finger_closing.hpp"
#include "core/grasp/grasp_set.hpp"
#include "core/grasp/surface_samples.hpp"
#include "core/grasp/thinning.hpp"
#include "core/grasp/wrench_quality.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace handover {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kMaxPalmGap =
    0.06;  // farther off, the hand does not hold it with its palm side [m]
constexpr double kMinQuality = 1e-3;  // weaker ones hold on paper only
constexpr double kWeakShare = 0.1;    // of the best quality; weaker ones only for want of others
constexpr double kFirstOpenings[] = {1.0, 0.65, 0.4};  // of Hand::open, tried until one can close
constexpr double kStandOffs[] = {0.0, 0.006, 0.014,
                                 0.024};  // from as near as the hand can come [m]

/// Where an object is and how large, to weigh moments against forces.
struct Extent {
  Vector3d centre = Vector3d::Zero();
  double size = 0;
  Vector3d long_axis = Vector3d::UnitZ();  // of O, along the longest edge of its box
};

Extent extentOf(const std::vector<SurfaceSample>& samples) {
  Extent extent;
  Vector3d low = samples.front().p_O;
  Vector3d high = low;
  for (const SurfaceSample& s : samples) {
    extent.centre += s.p_O / static_cast<double>(samples.size());
    low = low.cwiseMin(s.p_O);
    high = high.cwiseMax(s.p_O);
  }
  for (const SurfaceSample& s : samples)
    extent.size = std::max(extent.size, (s.p_O - extent.centre).norm());
  int longest = 2;  // ties within 5 %: the later axis wins, so a cube's is z
  for (int axis = 1; axis >= 0; --axis) {
    if ((high - low)[axis] > 1.05 * (high - low)[longest]) longest = axis;
  }
  extent.long_axis = Vector3d::Unit(longest);
  return extent;
}

/// The tool with its approach axis against the normal, `gap` between palm and sample, one of its
/// other axes along the object's long one, then turned by `roll`.
Pose toolPose(const SurfaceSample& sample, const HandModel& hand, const Extent& extent, double gap,
              double roll) {
  const auto frame = [](const Vector3d& main, const Vector3d& hint, const Vector3d& other_hint) {
    Vector3d side = hint - hint.dot(main) * main;
    if (side.norm() < 0.1) side = other_hint - other_hint.dot(main) * main;
    side.normalize();
    Eigen::Matrix3d R;
    R << main, side, main.cross(side);
    return R;
  };
  const Vector3d other(extent.long_axis.y(), extent.long_axis.z(), extent.long_axis.x());
  const Eigen::Matrix3d R_OF = frame(-sample.n_O, extent.long_axis, other);
  const Eigen::Matrix3d R_TF = frame(hand.approach_T, Vector3d::UnitX(), Vector3d::UnitY());
  Pose X_OT = Pose::Identity();
  X_OT.linear() = Eigen::AngleAxisd(roll, -sample.n_O) * R_OF * R_TF.transpose();
  X_OT.translation() = sample.p_O + (gap + hand.palm_extent) * sample.n_O;
  return X_OT;
}

/// The pose a file gives back for this one, so that a set read is the set made, to the bit. Writing
/// and reading can go round between neighbouring numbers for ever: then the pose is turned by a
/// nanoradian.
Pose asWritten(Pose X) {
  for (int nudge = 0; nudge < 20; ++nudge) {
    for (int i = 0; i < 5; ++i) {
      const Pose again = toPose(toValue(X));
      if (again.matrix() == X.matrix()) return X;
      X = again;
    }
    X.linear() = X.linear() * Eigen::AngleAxisd(1e-9, Vector3d(0.36, 0.48, 0.8)).toRotationMatrix();
  }
  return X;
}

class Generator {
 public:
  Generator(const SceneObject& object, HandModel hand, const GraspParams& params,
            const Extent& extent)
      : closer_(object, std::move(hand), GraspRules{}), params_(params), extent_(extent) {}

  /// Whether as many fingers are on the object as the hand has, or three: they hold it though one
  /// slips.
  bool handIsFull(const Grasp& grasp) const {
    std::set<int> fingers;
    for (const GraspContact& contact : grasp.contacts)
      fingers.insert(closer_.fingerOf(contact.link));
    fingers.erase(-1);
    return fingers.size() >= std::min<std::size_t>(3, closer_.hand().hand.fingers.size());
  }

  /// The grasp above a sample at one roll, as near as the hand can hold, or nullopt.
  std::optional<Grasp> graspAbove(const SurfaceSample& sample, double roll) {
    const Hand& hand = closer_.hand().hand;
    for (const double part : kFirstOpenings) {
      const VectorXd open = hand.closed + part * (hand.open - hand.closed);
      const Pose X_near = toolPose(sample, closer_.hand(), extent_, params_.palm_gap, roll);
      const auto back = closer_.advance(X_near, open, 2.0 * kMaxPalmGap, 0.0);
      if (!back || *back + params_.palm_gap > kMaxPalmGap) continue;
      for (const double stand_off : kStandOffs) {
        const double gap = params_.palm_gap + *back + stand_off;
        if (gap > kMaxPalmGap) break;
        auto grasp = closeAt(asWritten(toolPose(sample, closer_.hand(), extent_, gap, roll)), open);
        if (grasp) return grasp;
      }
    }
    return std::nullopt;
  }

 private:
  std::optional<Grasp> closeAt(const Pose& X_OT, const VectorXd& open) {
    Grasp grasp;
    grasp.X_OT = X_OT;
    grasp.closed = closer_.close(X_OT, open);
    grasp.contacts = closer_.contacts(X_OT, grasp.closed);
    if (grasp.contacts.empty()) return std::nullopt;
    grasp.quality = quality(grasp.contacts);
    if (grasp.quality < kMinQuality) return std::nullopt;
    const auto opening = closer_.leastOpening(X_OT, grasp.closed, open);
    if (!opening) return std::nullopt;
    grasp.open = *opening;
    return grasp;
  }

  double quality(const std::vector<GraspContact>& contacts) const {
    std::vector<ContactPoint> points;
    for (const GraspContact& c : contacts) points.push_back({c.p_O, c.n_O});
    ContactModel model;
    model.friction = params_.friction;
    return largestBall(contactWrenches(points, extent_.centre, extent_.size, model));
  }

  FingerClosing closer_;
  GraspParams params_;
  Extent extent_;
};

bool better(const Grasp& a, const Grasp& b) { return a.quality > b.quality; }

/// `wanted` of the full-handed grasps that are not weak, spread out; where those are too few, the
/// best of the others too.
std::vector<Grasp> chosen(std::vector<Grasp> full, std::vector<Grasp> others, int wanted) {
  double best = 0;
  for (const Grasp& grasp : full) best = std::max(best, grasp.quality);
  const auto weak = std::stable_partition(full.begin(), full.end(), [&](const Grasp& grasp) {
    return grasp.quality >= kWeakShare * best;
  });
  std::stable_sort(others.begin(), others.end(), better);
  others.insert(others.begin(), weak, full.end());
  std::stable_sort(others.begin(), others.begin() + (full.end() - weak), better);
  full.erase(weak, full.end());
  const auto missing =
      static_cast<std::size_t>(wanted) - std::min<std::size_t>(full.size(), wanted);
  full.insert(full.end(), others.begin(),
              others.begin() + static_cast<std::ptrdiff_t>(std::min(missing, others.size())));
  return thin(full, wanted);
}

std::optional<Error> stopped(const Deadline& deadline) {
  switch (deadline.state()) {
    case Deadline::State::kCancelled:
      return Error{ErrorCode::kCancelled, "cancelled while making grasps"};
    case Deadline::State::kPassed:
      return Error{ErrorCode::kDeadline, "deadline passed while making grasps"};
    case Deadline::State::kOpen:
      break;
  }
  return std::nullopt;
}

std::optional<Error> faultOf(const SceneObject& object, const RobotModel& model, int arm,
                             const GraspParams& params) {
  const auto bad = [](std::string detail) {
    return Error{ErrorCode::kInvalidInput, std::move(detail)};
  };
  if (object.shapes.empty()) return bad("object " + object.name + " has no shapes");
  if (arm < 0 || arm >= static_cast<int>(model.arms.size()))
    return bad(model.name + " has no arm " + std::to_string(arm));
  const Arm& a = model.arms[static_cast<std::size_t>(arm)];
  if (a.hand < 0) return bad("arm " + a.name + " of " + model.name + " has no hand");
  if (params.wanted < 1 || params.rolls < 1)
    return bad("wanted and rolls of a grasp set must be positive");
  if (!(params.surplus >= 1) || !(params.friction > 0) || !(params.palm_gap >= 0)) {
    return bad("surplus of a grasp set must be >= 1, friction > 0, palm_gap >= 0");
  }
  return std::nullopt;
}

}  // namespace

Result<GraspSet> generateGrasps(const SceneObject& object, const RobotModel& model, int arm,
                                const GraspParams& params,
                                const std::function<void(double)>& progress,
                                const Deadline& deadline) {
  if (auto fault = faultOf(object, model, arm, params)) return *fault;
  SamplingParams sampling;
  sampling.seed = params.seed;
  const std::vector<SurfaceSample> samples = sampleSurface(object.shapes, sampling);
  if (samples.empty())
    return {ErrorCode::kNotFound, "object " + object.name + " has no exposed surface"};

  const Arm& a = model.arms[static_cast<std::size_t>(arm)];
  GraspSet set;
  set.object = object.name;
  set.robot = model.name;
  set.hand = model.hands[static_cast<std::size_t>(a.hand)].name;
  Generator generator(object, extractEndEffector(model, arm), params, extentOf(samples));
  const auto enough = static_cast<std::size_t>(std::ceil(params.surplus * params.wanted));
  std::vector<Grasp> full,
      partial;  // with as many fingers on the object as can be asked for, or less
  const auto known = [&](const Grasp& grasp, const std::vector<Grasp>& grasps) {
    return std::any_of(grasps.begin(), grasps.end(), [&](const Grasp& other) {
      return tooClose(grasp, other, params.min_spacing, params.min_angle);
    });
  };
  // Samples come in farthest-point order: wherever we stop, they are even over the surface.
  for (std::size_t s = 0; s < samples.size() && full.size() < enough; ++s) {
    for (int roll = 0; roll < params.rolls; ++roll) {
      if (auto error = stopped(deadline)) return *error;
      const auto grasp = generator.graspAbove(samples[s], 2.0 * M_PI * roll / params.rolls);
      if (!grasp || known(*grasp, full) || known(*grasp, partial)) continue;
      (generator.handIsFull(*grasp) ? full : partial).push_back(*grasp);
    }
    if (progress) {
      progress(
          std::max(static_cast<double>(s + 1) / static_cast<double>(samples.size()),
                   std::min(1.0, static_cast<double>(full.size()) / static_cast<double>(enough))));
    }
  }
  set.grasps = chosen(std::move(full), std::move(partial), params.wanted);
  if (set.grasps.empty()) {
    return {ErrorCode::kNotFound,
            "hand " + set.hand + " of " + model.name + " cannot hold object " + object.name};
  }
  std::stable_sort(set.grasps.begin(), set.grasps.end(), better);
  return set;
}

}  // namespace handover
