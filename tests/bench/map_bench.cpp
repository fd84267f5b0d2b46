// SPDX-License-Identifier: Apache-2.0
#include "benches.hpp"
#include "core/reachability/reachability_map.hpp"
#include "rounds.hpp"
#include "temporary_folder.hpp"

#include <Eigen/Geometry>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

namespace handover::bench {
namespace {

/// §IV-A written straight down: configurations evenly within limits, pose and Jacobian by the
/// joints one after the other, sqrt(det(J J^T)) into the voxel of the tool.
class PlainMap {
 public:
  PlainMap(const RobotModel& model, const Arm& arm, double voxel)
      : voxel_(voxel), cells_(static_cast<std::size_t>(kSize) * kSize * kSize) {
    for (LinkId link = arm.tool_link; link != arm.base_link;) {
      const Joint& joint = model.joints[model.links[link].parent_joint];
      joints_.insert(joints_.begin(), joint);
      link = joint.parent_link;
    }
    J_.resize(6, static_cast<Eigen::Index>(arm.dofs.size()));
  }

  void sample(int samples) {
    std::mt19937_64 random(1);
    ArmVector q(J_.cols());
    for (int n = 0; n < samples; ++n) {
      draw(random, q);
      const Eigen::Isometry3d X_AT = toolPose(q);
      add(X_AT.translation(), manipulability());
    }
  }

  /// Evenly within the limits.
  void draw(std::mt19937_64& random, ArmVector& q) const {
    int i = 0;
    for (const Joint& joint : joints_) {
      if (joint.type == JointType::kFixed) continue;
      q[i++] = std::uniform_real_distribution(joint.lower, joint.upper)(random);
    }
  }

  double manipulability(const ArmVector& q) {
    toolPose(q);
    return manipulability();
  }

  int filledVoxels() const {
    return static_cast<int>(
        std::count_if(cells_.begin(), cells_.end(), [](const Cell& it) { return it.samples > 0; }));
  }

 private:
  static constexpr int kSize = 64;

  struct Cell {
    double sum = 0;
    int samples = 0;
  };

  double manipulability() const { return std::sqrt((J_ * J_.transpose()).determinant()); }

  /// The Jacobian goes to J_.
  Eigen::Isometry3d toolPose(const ArmVector& q) {
    std::array<Eigen::Vector3d, 8> axes, points;
    std::size_t moving = 0;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (const Joint& joint : joints_) {
      X = X * joint.X_PJ;
      if (joint.type == JointType::kFixed) continue;
      axes[moving] = X.linear() * joint.axis;
      points[moving] = X.translation();
      X = X * Eigen::AngleAxisd(q[static_cast<Eigen::Index>(moving)], joint.axis);
      ++moving;
    }
    for (std::size_t i = 0; i < moving; ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      J_.col(column).head<3>() = axes[i].cross(X.translation() - points[i]);
      J_.col(column).tail<3>() = axes[i];
    }
    return X;
  }

  void add(const Eigen::Vector3d& p, double manipulability) {
    std::size_t index = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int at = static_cast<int>(std::floor(p[axis] / voxel_)) + kSize / 2;
      index = index * kSize + static_cast<std::size_t>(at);
    }
    cells_.at(index).sum += manipulability;
    ++cells_[index].samples;
  }

  double voxel_;
  std::vector<Joint> joints_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> J_;
  std::vector<Cell> cells_;
};

/// Throws unless both sides compute the same.
void compare(const RobotModel& model, ArmId arm_index, PlainMap& plain) {
  const ArmKinematics arm(model, arm_index);
  std::mt19937_64 random(2);
  ArmVector q(arm.dofs());
  for (int n = 0; n < 100; ++n) {
    plain.draw(random, q);
    if (std::abs(plain.manipulability(q) - arm.manipulability(q)) > 1e-9) {
      throw std::runtime_error("the plain loop's manipulability is not ours");
    }
  }
}

Row mapOf(const SceneRobot& robot, const ArmName& name, const Effort& effort) {
  // One arm alone: a robot's maps are sampled together.
  RobotModel model = *robot.model;
  model.arms = {model.arms.at(model.findArm(name.arm))};
  ReachabilityParams params;
  params.samples = static_cast<std::uint64_t>(effort.samples);
  const test::TemporaryFolder folder;
  const std::vector<std::filesystem::path> files{folder / "bench.map"};
  PlainMap plain(model, model.arms.front(), params.voxel);
  compare(model, ArmId(0), plain);
  const auto times = medianRounds(
      effort.rounds, {[&] {
                        const auto built = ReachabilityMap::build(model, robot.q_start, params, {},
                                                                  files, nullptr, Deadline());
                        if (!built) throw std::runtime_error(built.error().detail);
                      },
                      [&] {
                        plain.sample(effort.samples);
                        benchmark::DoNotOptimize(plain.filledVoxels());
                      }});
  return {std::string("map of ") + name.title + ", a sample", times[0] / effort.samples * 1e9,
          times[1] / effort.samples * 1e9, "plain Eigen loop into voxels", "ns"};
}

}  // namespace

Report mapBench(const Scene& scene, const Effort& effort) {
  Report report;
  for (const ArmName& arm : kArms) {
    report.rows.push_back(mapOf(scene.robots[scene.findRobot(arm.robot)], arm, effort));
  }
  report.notes.push_back(
      "Maps: without tests for self-collision on either side; ours also keeps directions and the "
      "best sample of each voxel, and writes the file.");
  return report;
}

}  // namespace handover::bench
