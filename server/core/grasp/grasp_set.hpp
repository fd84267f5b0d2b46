// SPDX-License-Identifier: Apache-2.0
// Grasps of one object by one hand, made offline ([paper] §V: surface samples, palm just above,
// approach along the normal, 4 rolls, fingers closed until contact).
#pragma once

#include "core/model/scene.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/result.hpp>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace handover {

struct GraspContact {
  std::string link;
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();   ///< on the object's surface
  Eigen::Vector3d n_O = Eigen::Vector3d::UnitZ();  ///< outward normal of the object
};

struct Grasp {
  Pose X_OT = Pose::Identity();
  Eigen::VectorXd open;    ///< hand joints before closing, Hand::dofs order
  Eigen::VectorXd closed;  ///< at contact
  std::vector<GraspContact> contacts;
  double quality = 0;  ///< force closure: radius of the largest wrench ball
};

struct GraspSet {
  std::string object, robot, hand;
  std::vector<Grasp> grasps;  ///< best quality first, ties by generation order
};

struct GraspParams {
  int wanted = 368;         ///< Table I's number
  double surplus = 1.2;     ///< made at least surplus * wanted, then thinned
  double palm_gap = 0.008;  ///< palm above the sample [m]
  int rolls = 4;
  double min_spacing = 0.005;             ///< no two grasps within both of these
  double min_angle = 0.1745329251994330;  ///< [rad]
  double friction = 0.6;
  std::uint64_t seed = 1;
};

/// Hash of all that decides a set's content: object shapes, hand links, postures, parameters.
std::uint64_t graspSetHash(const SceneObject& object, const RobotModel& model, int arm,
                           const GraspParams& params);

/// Makes the grasps of an object with the hand of a robot's arm. kNotFound when there are none.
Result<GraspSet> generateGrasps(const SceneObject& object, const RobotModel& model, int arm,
                                const GraspParams& params,
                                const std::function<void(double)>& progress,
                                const Deadline& deadline);

/// JSON file, temporary name then rename.
Result<bool> writeGraspSet(const GraspSet& set, std::uint64_t hash,
                           const std::filesystem::path& file);
/// kNotFound: no file; kInvalidInput: not ours, malformed or another hash (the detail says what).
Result<GraspSet> readGraspSet(const std::filesystem::path& file, std::uint64_t expected_hash);

}  // namespace handover
