// SPDX-License-Identifier: Apache-2.0
// What makes grasps: one sort of maker per kind of gripper. Samples, thinning and the file are the
// same for all (grasp_set_generator.cpp).
#pragma once

#include "core/grasp/grasp_set.hpp"
#include "core/grasp/hand_model.hpp"
#include "core/grasp/surface_samples.hpp"

#include <memory>
#include <string>
#include <vector>

namespace handover {

class GraspMaker {
 public:
  virtual ~GraspMaker() = default;

  /// The grasps above one place of the surface, at most one per roll, in the order of the rolls.
  virtual std::vector<Grasp> graspsAt(const SurfaceSample& sample) = 0;
  /// Whether a grasp is one of those that are asked for; others only make up the number.
  virtual bool isFull(const Grasp& grasp) const = 0;
  /// Why there is none, after graspsAt() of all places.
  virtual std::string whyNone() = 0;
};

/// Those below keep a reference to nothing but copy what they need.
std::unique_ptr<GraspMaker> makeFingerGrasps(const SceneObject& object, HandModel hand,
                                             const GraspParams& params,
                                             const std::vector<SurfaceSample>& samples);
/// @pre the hand has a cup.
std::unique_ptr<GraspMaker> makeSuctionGrasps(const SceneObject& object, HandModel hand,
                                              const GraspParams& params,
                                              const std::vector<SurfaceSample>& samples);

inline constexpr double kMinQuality = 1e-3;  // weaker ones hold on paper only

/// Where an object is and how large, to weigh moments against forces.
struct Extent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double size = 0;
  Eigen::Vector3d box = Eigen::Vector3d::Zero();         // edges, along O's axes
  Eigen::Vector3d long_axis = Eigen::Vector3d::UnitZ();  // of O, along the longest edge of its box
};

/// @pre there are samples.
Extent extentOf(const std::vector<SurfaceSample>& samples);

/// The tool with its approach axis against the normal, its origin `height` above the sample, one of
/// its other axes along the object's long one, then turned by `roll`.
Pose toolPose(const SurfaceSample& sample, const HandModel& hand, const Extent& extent,
              double height, double roll);

/// The pose a file gives back for this one, so that a set read is the set made, to the bit. Writing
/// and reading can go round between neighbouring numbers for ever: then the pose is turned by a
/// nanoradian.
Pose asWritten(Pose X);

}  // namespace handover
