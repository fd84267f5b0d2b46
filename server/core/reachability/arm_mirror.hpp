// SPDX-License-Identifier: Apache-2.0
// Are two arms of one robot mirror images of each other? Judged by their joints, tools and limits,
// never by their names.
#pragma once

#include "core/model/robot_model.hpp"

#include <handover/common/result.hpp>

namespace handover {

/// How one arm's configurations and tool positions become those of its mirror image. Reflected in
/// the plane, arm `from` at q is arm `to` at image(q): the same tool position, the same approach
/// direction, the same manipulability.
struct ArmMirror {
  /// From the base frame of `from` to that of `to`: the reflection in the plane as both see it.
  /// Entries 0, 1 and -1, determinant -1, z onto z or -z; so voxels fall on voxels and direction
  /// bins on direction bins.
  Eigen::Matrix3d S_ToFrom = Eigen::Matrix3d::Identity();
  ArmVector sign;  ///< per joint: 1, or -1 where the image turns (or slides) the other way

  /// The image's configuration [rad or m].
  ArmVector image(const ArmVector& q) const { return sign.cwiseProduct(q); }
};

/// Looks for a plane x = 0, y = 0 or z = 0 of the link from which both arms branch off in which
/// `to` is the image of `from`: joint axes and tool position to 1e-6 m and rad, approach directions
/// too, joint limits under the signs to 1e-6. Joints between that link and the arms stand as in
/// `q`. What the map does not use does not count: shapes, the tool's turn about its approach axis.
/// @return kNotFound with what differs (in the plane where most agrees) when there is none.
/// @throws std::out_of_range for an arm that does not exist.
Result<ArmMirror> findArmMirror(const RobotModel& model, ArmId from, ArmId to,
                                const RobotVector& q);

}  // namespace handover
