// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/finger_closing.hpp"
#include "core/grasp/grasp_maker.hpp"
#include "core/grasp/wrench_quality.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace handover {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kMaxPalmGap =
    0.06;  // farther off, the hand does not hold it with its palm side [m]
constexpr double kFirstOpenings[] = {1.0, 0.65, 0.4};  // of Hand::open, tried until one can close
constexpr double kStandOffs[] = {0.0, 0.006, 0.014,
                                 0.024};  // from as near as the hand can come [m]

/// Three digits at most of what is small, whole numbers of what is not.
std::string rounded(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), std::abs(number) < 100 ? "%.3g" : "%.0f", number);
  return text;
}

class FingerGrasps : public GraspMaker {
 public:
  FingerGrasps(const SceneObject& object, HandModel hand, const GraspParams& params,
               const Extent& extent)
      : closer_(object, std::move(hand), GraspRules{}), params_(params), extent_(extent) {}

  std::vector<Grasp> graspsAt(const SurfaceSample& sample) override {
    std::vector<Grasp> grasps;
    for (int roll = 0; roll < params_.rolls; ++roll) {
      if (auto grasp = graspAbove(sample, 2.0 * M_PI * roll / params_.rolls)) {
        grasps.push_back(std::move(*grasp));
      }
    }
    return grasps;
  }

  /// Whether as many fingers are on the object as the hand has, or three: they hold it though one
  /// slips.
  bool isFull(const Grasp& grasp) const override {
    std::set<int> fingers;
    for (const GraspContact& contact : grasp.contacts)
      fingers.insert(closer_.fingerOf(contact.link));
    fingers.erase(-1);
    return fingers.size() >= std::min<std::size_t>(3, closer_.hand().hand.fingers.size());
  }

  std::string whyNone() override {
    if (closer_.hand().hand.finger_links.size() < 2) return "its gripper has no two finger links";
    const Vector3d size = 1e3 * extent_.box;
    char text[192];
    std::snprintf(
        text, sizeof(text),
        "fingers that open to %.0f mm, with %.0f mm of room on each side, hold it nowhere; "
        "its box is %s x %s x %s mm",
        1e3 * closer_.opening(), 1e3 * GraspRules{}.clearance, rounded(size.x()).c_str(),
        rounded(size.y()).c_str(), rounded(size.z()).c_str());
    return text;
  }

 private:
  /// The hand with its palm `gap` above a sample.
  Pose above(const SurfaceSample& sample, double gap, double roll) const {
    return toolPose(sample, closer_.hand(), extent_, gap + closer_.hand().palm_extent, roll);
  }

  /// The grasp above a sample at one roll, as near as the hand can hold, or nullopt.
  std::optional<Grasp> graspAbove(const SurfaceSample& sample, double roll) {
    const Hand& hand = closer_.hand().hand;
    for (const double part : kFirstOpenings) {
      const VectorXd open = hand.closed + part * (hand.open - hand.closed);
      const Pose X_near = above(sample, params_.palm_gap, roll);
      const auto back = closer_.advance(X_near, open, 2.0 * kMaxPalmGap, 0.0);
      if (!back || *back + params_.palm_gap > kMaxPalmGap) continue;
      for (const double stand_off : kStandOffs) {
        const double gap = params_.palm_gap + *back + stand_off;
        if (gap > kMaxPalmGap) break;
        auto grasp = closeAt(asWritten(above(sample, gap, roll)), open);
        if (grasp) return grasp;
      }
    }
    return std::nullopt;
  }

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

}  // namespace

std::unique_ptr<GraspMaker> makeFingerGrasps(const SceneObject& object, HandModel hand,
                                             const GraspParams& params,
                                             const std::vector<SurfaceSample>& samples) {
  return std::make_unique<FingerGrasps>(object, std::move(hand), params, extentOf(samples));
}

}  // namespace handover
