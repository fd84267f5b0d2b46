// SPDX-License-Identifier: Apache-2.0
// Grasps of one object by one hand, made offline ([paper] §V: surface samples, palm just above,
// approach along the normal, 4 rolls, fingers closed until contact); of a suction cup: the same
// samples and rolls, the cup on the surface where it can seal.
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
  /// Hand joints before closing, Hand::dofs order: no wider than coming along the approach needs,
  /// on the straight line from `closed` towards Hand::open, along which no finger enters the
  /// object.
  Eigen::VectorXd open;
  Eigen::VectorXd closed;  ///< at contact
  std::vector<GraspContact> contacts;
  /// Of a cup: how near the object's centre of volume is to the line of pull, times how flat the
  /// patch is; at most 1. Of fingers, force closure: radius of the largest wrench ball
  /// (Ferrari-Canny) of soft fingers of unit normal force, or at most 10 % less
  /// (wrench_quality.hpp).
  double quality = 0;
};

struct GraspSet {
  std::string object, robot, hand;
  std::vector<Grasp> grasps;  ///< best quality first, ties by generation order
  std::string none_because;   ///< where there are none: why
};

struct GraspParams {
  int wanted = 368;         ///< Table I's number
  double surplus = 1.2;     ///< made at least surplus * wanted, then thinned
  double palm_gap = 0.008;  ///< palm above the sample [m]
  int rolls = 4;
  double min_spacing = 0.005;             ///< no two grasps within both of these
  double min_angle = 0.1745329251994330;  ///< [rad]
  double friction = 0.6;                  ///< Coulomb's, of the contacts
  /// How far a surface may leave the plane of a cup's lip, anywhere within it, as a share of the
  /// cup's radius. A tenth: the strain up to which the lip of a usual cup follows the surface and
  /// seals (Mahler et al., Dex-Net 3.0, 2018, take 10 % of its springs' lengths).
  double seal_bend = 0.1;
  /// What a cup pulls with, in weights of the object. Held by the rim, a cup of radius r withstands
  /// the moment of this force times r, so that the object's centre may be `holding * r` off the
  /// line of pull. 2: makers of cups ask for a pull of twice the weight.
  double holding = 2.0;
  std::uint64_t seed = 1;
};

/// How far a cup's shape stays off the surface that it holds [m]: it must not touch before its
/// grasp begins, and the arm does not move while the vacuum builds up.
inline constexpr double kCupGap = 0.0008;

/// Hash of all that decides a set's content: object shapes, hand links, postures, parameters.
std::uint64_t graspSetHash(const SceneObject& object, const RobotModel& model, ArmId arm,
                           const GraspParams& params);

/// Makes the grasps of an object with the hand of a robot's arm, params.wanted of them or all there
/// are. Samples come in farthest-point order until surplus * wanted grasps hold with three fingers
/// (or all, of a hand with fewer). Those not far weaker than the best are thinned; only where they
/// are too few do weak ones, then those of fewer fingers, make up the number. The palm is palm_gap
/// above the sample, or as near as the open hand can come (its knuckles may stand before the palm),
/// at most 6 cm. Every grasp: hand and
/// wrist 4 mm off the object when open and 0.10 m straight back; fingers closed to 0.4-0.6 mm off
/// it; two of their links within 1 mm with normals more than 130 deg apart; palm and wrist 3 mm
/// off; no part of the hand within 2 mm of another.
///
/// A cup: its axis along the inward normal, the tool's origin at most 1.8 mm above the surface, the
/// cup's shape kCupGap off it, all else of the hand 4 mm, and so 0.10 m straight back; the surface
/// within params.seal_bend of flat all over the seal, without edge, step or hole; the centre of
/// volume at most params.holding radii off the line of pull.
///
/// The same bytes for the same input. Where there are none the set says why;
/// kInvalidInput for an arm without hand, an object without shapes or
/// parameters out of range; kCancelled, kDeadline.
Result<GraspSet> generateGrasps(const SceneObject& object, const RobotModel& model, ArmId arm,
                                const GraspParams& params,
                                const std::function<void(double)>& progress,
                                const Deadline& deadline);

/// JSON file, temporary name then rename.
Result<void> writeGraspSet(const GraspSet& set, std::uint64_t hash,
                           const std::filesystem::path& file);
/// kNotFound: no file; kInvalidInput: not ours, malformed or another hash (the detail says what).
Result<GraspSet> readGraspSet(const std::filesystem::path& file, std::uint64_t expected_hash);

}  // namespace handover
