// SPDX-License-Identifier: Apache-2.0
#include "core/collision/collision_scene.hpp"
#include "core/grasp/grasp_maker.hpp"
#include "core/grasp/object_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace handover {
namespace {

using Eigen::Vector3d;

// The seal is looked at along circles this far apart, at points this far apart [m]: holes and slits
// that are wider are seen.
constexpr double kLook = 0.002;
constexpr int kLeastAround = 16;
/// A lip follows a slope that the bend of a tenth of its radius brings with it (11.5 deg), no edge.
constexpr double kSealTilt = 15 * M_PI / 180;
// The contract has the cup's axis within 5 deg of the normal where the surface is nearest to the
// tool's origin, 2 mm away at most.
constexpr double kCentreTilt = 4 * M_PI / 180;
constexpr double kCentre = 0.0025;
constexpr double kMostOff = 0.0018;     // of the tool's origin, off the surface; allowed: 2 mm
constexpr double kClearance = 0.004;    // of the hand but the cup: margins touch below 2 mm [m]
constexpr double kRetreat = 0.10;       // length of the straight approach [m]
constexpr double kLeastStep = 1e-4;     // of the hand on its way back [m]
constexpr double kLookAhead = 0.04;     // distances are asked for up to this [m]
constexpr double kGapTolerance = 5e-5;  // of kCupGap [m]

class SuctionGrasps : public GraspMaker {
 public:
  SuctionGrasps(const SceneObject& object, HandModel hand, const GraspParams& params,
                const Extent& extent)
      : hand_(std::move(hand)),
        params_(params),
        extent_(extent),
        surface_(object),
        radius_(hand_.hand.suction->radius),
        world_(handAndObject(object, hand_)),
        object_(world_.scene().objectBody(ObjectId(0))) {
    const RobotModel& model = *hand_.model;
    for (const LinkId link : IdRange<LinkId>(model.links.size())) {
      const BodyId body = world_.scene().linkBody(RobotId(0), link);
      if (!body.valid()) continue;
      (link == hand_.hand.palm_link ? cup_ : others_).push_back(body);
    }
  }

  std::vector<Grasp> graspsAt(const SurfaceSample& sample) override {
    ++places_;
    const std::optional<double> bend = bendOfSeal(sample);
    if (!bend) return {};
    ++sealed_;
    const Vector3d to_centre = surface_.centre() - sample.p_O;
    const double aside = to_centre.cross(sample.n_O).norm();
    const double quality = (1 - aside / mostAside()) * (1 - 0.5 * *bend / mostBend());
    if (aside >= mostAside() || quality < kMinQuality) return {};
    ++balanced_;
    std::vector<Grasp> grasps;
    for (int roll = 0; roll < params_.rolls; ++roll) {
      const auto X_OT = placeCup(sample, 2.0 * M_PI * roll / params_.rolls);
      if (!X_OT) continue;
      Grasp grasp;
      grasp.X_OT = *X_OT;
      const Link& cup = hand_.model->links[hand_.hand.palm_link];
      grasp.contacts = {{cup.name, sample.p_O, sample.n_O}};
      grasp.quality = quality;
      grasps.push_back(std::move(grasp));
    }
    return grasps;
  }

  bool isFull(const Grasp&) const override { return true; }

  std::string whyNone() override {
    char text[256];
    const double radius = 1e3 * radius_;
    if (sealed_ == 0) {
      std::snprintf(
          text, sizeof(text),
          "a cup of radius %.0f mm seals at none of %d places on its surface: it bends by "
          "more than %.1f mm or ends below the seal",
          radius, places_, 1e3 * mostBend());
    } else if (balanced_ == 0) {
      std::snprintf(text, sizeof(text),
                    "a cup of radius %.0f mm seals at %d of %d places on its surface, all with the "
                    "object's centre more than %.0f mm off the line of pull",
                    radius, sealed_, places_, 1e3 * mostAside());
    } else {
      std::snprintf(text, sizeof(text),
                    "a cup of radius %.0f mm could hold it at %d of %d places on its surface, but "
                    "the hand is in the way",
                    radius, balanced_, places_);
    }
    return text;
  }

 private:
  double mostBend() const { return params_.seal_bend * radius_; }

  double mostAside() const { return params_.holding * radius_; }

  /// How far the surface leaves the plane below the cup [m]; nullopt: too far, or there is an edge,
  /// a step or a hole.
  std::optional<double> bendOfSeal(const SurfaceSample& sample) const {
    const Vector3d side = sample.n_O.unitOrthogonal();
    const Vector3d other = sample.n_O.cross(side);
    double bend = 0;
    const int circles = std::max(2, static_cast<int>(std::ceil(radius_ / kLook)));
    for (int circle = circles; circle > 0; --circle) {  // most places fail at the rim
      const double r = radius_ * circle / circles;
      const int around = std::max(kLeastAround, static_cast<int>(std::ceil(2 * M_PI * r / kLook)));
      const double steepest = r <= kCentre ? kCentreTilt : kSealTilt;
      for (int i = 0; i < around; ++i) {
        const double angle = 2 * M_PI * i / around;
        const Vector3d p = sample.p_O + r * (std::cos(angle) * side + std::sin(angle) * other);
        const double reach = 2 * mostBend() + 1e-3;
        const auto below = surface_.firstHit(p + reach * sample.n_O, p - reach * sample.n_O);
        if (!below) return std::nullopt;
        bend = std::max(bend, std::abs((below->p_O - p).dot(sample.n_O)));
        if (bend > mostBend() || below->n_O.dot(sample.n_O) < std::cos(steepest)) {
          return std::nullopt;
        }
      }
    }
    return bend;
  }

  /// The tool with the cup's shape kCupGap off the surface and nothing else of the hand near it,
  /// there and all the way straight back.
  std::optional<Pose> placeCup(const SurfaceSample& sample, double roll) {
    double height = std::max(0.0, kCupGap + hand_.palm_extent);
    while (height <= kMostOff) {
      const Pose X_OT = asWritten(toolPose(sample, hand_, extent_, height, roll));
      place(X_OT);
      const double gap = distance(cup_);
      if (gap >= kCupGap - kGapTolerance) {
        return freeBack(X_OT) ? std::optional(X_OT) : std::nullopt;
      }
      height += std::max(kCupGap - gap, kGapTolerance);  // a hollow: its rim is nearer
    }
    return std::nullopt;
  }

  bool freeBack(const Pose& X_OT) {
    for (double back = 0;;) {
      place(X_OT * Eigen::Translation3d(-back * hand_.approach_T));
      const double slack = std::min(distance(cup_) - 0.5 * kCupGap, distance(others_) - kClearance);
      if (slack < 0) return false;
      if (back >= kRetreat) return true;
      back = std::min(kRetreat, back + std::max(slack, kLeastStep));
    }
  }

  void place(const Pose& X_OT) {
    linkPoses(*hand_.model, X_OT * hand_.X_RT.inverse(), restingPosture(*hand_.model), X_OL_);
    world_.setRobot(RobotId(0), X_OL_);
  }

  /// Of the nearest of some bodies to the object, up to kLookAhead.
  double distance(const std::vector<BodyId>& bodies) {
    double least = kLookAhead;
    for (const BodyId body : bodies) {
      if (const auto near = world_.distance(body, object_, least)) least = near->distance;
    }
    return least;
  }

  HandModel hand_;
  GraspParams params_;
  Extent extent_;
  ObjectSurface surface_;
  double radius_;
  CollisionWorld world_;
  BodyId object_;
  std::vector<BodyId> cup_, others_;  ///< of the hand
  std::vector<Pose> X_OL_;
  int places_ = 0, sealed_ = 0, balanced_ = 0;
};

}  // namespace

std::unique_ptr<GraspMaker> makeSuctionGrasps(const SceneObject& object, HandModel hand,
                                              const GraspParams& params,
                                              const std::vector<SurfaceSample>& samples) {
  return std::make_unique<SuctionGrasps>(object, std::move(hand), params, extentOf(samples));
}

}  // namespace handover
