// SPDX-License-Identifier: Apache-2.0
#include "benches.hpp"
#include "core/kinematics/arm_kinematics.hpp"
#include "kdl_robot.hpp"
#include "rounds.hpp"

#include <benchmark/benchmark.h>
#include <kdl/chainiksolverpos_lma.hpp>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

namespace handover::bench {
namespace {

// An answer counts when it is this near and within limits.
constexpr double kPositionTolerance = 1e-4, kRotationTolerance = 1e-3;
// Starts that KDL may take for a pose: the middle of the limits, then random ones.
constexpr int kSeeds = 10;

KDL::Frame toKdl(const Pose& X) {
  KDL::Frame frame;
  for (int row = 0; row < 3; ++row) {
    frame.p(row) = X.translation()[row];
    for (int column = 0; column < 3; ++column) frame.M(row, column) = X.linear()(row, column);
  }
  return frame;
}

class RandomConfigurations {
 public:
  explicit RandomConfigurations(const ArmKinematics& arm) : arm_(arm), random_(2014) {}

  ArmVector next() {
    ArmVector q(arm_.dofs());
    for (int i = 0; i < q.size(); ++i) {
      q[i] = std::uniform_real_distribution(arm_.lower()[i], arm_.upper()[i])(random_);
    }
    return q;
  }

 private:
  const ArmKinematics& arm_;
  std::mt19937_64 random_;
};

/// Levenberg-Marquardt from several starts; full turns are taken off before the limits are asked.
class KdlSolver {
 public:
  KdlSolver(const ArmKinematics& arm, KDL::Chain chain)
      : arm_(arm),
        chain_(std::move(chain)),
        solver_(chain_),
        start_(chain_.getNrOfJoints()),
        found_(chain_.getNrOfJoints()) {
    RandomConfigurations random(arm);
    seeds_.push_back(0.5 * (arm.lower() + arm.upper()));
    while (seeds_.size() < kSeeds) seeds_.push_back(random.next());
  }

  std::optional<ArmVector> solve(const KDL::Frame& X_AT) {
    for (const ArmVector& seed : seeds_) {
      start_.data = seed;
      if (solver_.CartToJnt(start_, X_AT, found_) < 0) continue;
      ArmVector q = found_.data;
      for (int i = 0; i < q.size(); ++i) {
        constexpr double kTurn = 2 * std::numbers::pi;
        q[i] -= kTurn * std::round((q[i] - seeds_[0][i]) / kTurn);
      }
      if (arm_.withinLimits(q)) return q;
    }
    return std::nullopt;
  }

 private:
  const ArmKinematics& arm_;
  KDL::Chain chain_;  // the solver only refers to it
  KDL::ChainIkSolverPos_LMA solver_;
  KDL::JntArray start_, found_;
  std::vector<ArmVector> seeds_;
};

std::optional<ArmVector> firstOfOurs(const ArmKinematics& arm, const Pose& X_AT) {
  std::optional<ArmVector> first;
  arm.visit(X_AT, {}, [&first](const ArmVector& q) {
    first = q;
    return false;
  });
  return first;
}

bool reaches(const ArmKinematics& arm, const std::optional<ArmVector>& q, const Pose& X_AT) {
  if (!q || !arm.withinLimits(*q)) return false;
  const Pose X = arm.toolPose(*q);
  return (X.translation() - X_AT.translation()).norm() <= kPositionTolerance &&
         Eigen::AngleAxisd(X.linear().transpose() * X_AT.linear()).angle() <= kRotationTolerance;
}

Report ikOf(const Scene& scene, const ArmName& name, const Effort& effort) {
  const RobotModel& model = *scene.robots[scene.findRobot(name.robot)].model;
  const ArmId index = model.findArm(name.arm);
  const Arm& described = model.arms[index];
  const auto link = [&model](LinkId id) { return model.links[id].name; };
  const ArmKinematics arm(model, index);
  const testing::KdlRobot kdl(std::filesystem::path(HANDOVER_SOURCE_DIR) / model.urdf_path);
  KdlSolver solver(arm, kdl.chain(link(described.base_link), link(described.tool_link)));

  std::vector<Pose> poses;
  std::vector<KDL::Frame> frames;
  RandomConfigurations random(arm);
  for (int k = 0; k < effort.poses + kSeeds; ++k) {
    const ArmVector q = random.next();
    if (k < kSeeds) continue;  // those are KDL's starts
    poses.push_back(arm.toolPose(q));
    frames.push_back(toKdl(poses.back()));
  }
  int solved_ours = 0, solved_kdl = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    solved_ours += reaches(arm, firstOfOurs(arm, poses[k]), poses[k]) ? 1 : 0;
    solved_kdl += reaches(arm, solver.solve(frames[k]), poses[k]) ? 1 : 0;
  }
  const auto times =
      medianRounds(effort.rounds, {[&] {
                                     for (const Pose& X_AT : poses) {
                                       benchmark::DoNotOptimize(firstOfOurs(arm, X_AT));
                                     }
                                   },
                                   [&] {
                                     for (const KDL::Frame& X_AT : frames) {
                                       benchmark::DoNotOptimize(solver.solve(X_AT));
                                     }
                                   }});
  const double count = static_cast<double>(poses.size());
  const std::string title = std::string("IK of ") + name.title;
  const std::string reference = "KDL ChainIkSolverPos_LMA, up to 10 starts";
  return {.rows = {{title + ", a pose", times[0] / count * 1e6, times[1] / count * 1e6, reference,
                    "us"},
                   {title + ", poses solved", 100 * solved_ours / count, 100 * solved_kdl / count,
                    reference, "%"}},
          .notes = {}};
}

}  // namespace

Report ikBench(const Scene& scene, const Effort& effort) {
  Report report;
  for (const ArmName& arm : kArms) report.add(ikOf(scene, arm, effort));
  report.notes.push_back("IK: poses of " + std::to_string(effort.poses) +
                         " random configurations within limits; the first answer within limits; "
                         "solved means to 1e-4 m and 1e-3 rad.");
  return report;
}

}  // namespace handover::bench
