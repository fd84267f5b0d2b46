// SPDX-License-Identifier: Apache-2.0
// A robot as a recording shows it: its links' collision shapes and where the joints put them.
#pragma once

#include <handover/common/geometry.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace handover::view {

/// Joint positions [rad, m] by name.
using Positions = std::map<std::string, double>;

struct Shape {
  Pose X_LS = Pose::Identity();
  Geometry geometry;  ///< a mesh's path is as the URDF has it
};

struct Link {
  std::string name;
  std::vector<Shape> collision;
};

struct Mimic {
  std::string joint;
  double multiplier = 1, offset = 0;
};

struct Joint {
  enum class Motion { kNone, kTurn, kSlide };

  std::string name;
  Motion motion = Motion::kNone;
  std::size_t parent = 0, child = 0;                ///< links
  Pose X_PJ = Pose::Identity();                     ///< joint frame in the parent link
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit, in the joint frame
  std::optional<Mimic> mimic;
};

class Robot {
 public:
  /// @param where names the URDF in errors. @throws client::PlanFileError
  Robot(const std::string& urdf, const std::string& where);

  const std::vector<Link>& links() const { return links_; }

  /// Of the joints that move, parents first.
  const std::vector<Joint>& joints() const { return joints_; }

  std::optional<std::size_t> findLink(const std::string& name) const;

  /// Mimic joints follow their law; a joint that `q` does not name is at 0.
  double positionOf(const Joint& joint, const Positions& q) const;

  /// X_WL of every link. @param X_WB of the root link.
  std::vector<Pose> linkPoses(const Pose& X_WB, const Positions& q) const;

 private:
  std::vector<Link> links_;
  std::vector<Joint> joints_;  ///< parents first
  std::map<std::string, std::size_t> index_;
};

}  // namespace handover::view
