// SPDX-License-Identifier: Apache-2.0
#include "benches.hpp"
#include "reference_checker.hpp"
#include "rounds.hpp"

#include <benchmark/benchmark.h>

#include <random>
#include <stdexcept>

namespace handover::bench {
namespace {

/// The scene with one arm that moves, for us and for the references.
class MovingArm {
 public:
  MovingArm(const std::shared_ptr<const Scene>& scene, const ArmName& name)
      : scene_(scene),
        robot_(scene->findRobot(name.robot)),
        model_(*scene->robots[robot_].model),
        arm_(model_.arms[model_.findArm(name.arm)]),
        world_(std::make_shared<const CollisionScene>(*scene)),
        checker_(world_, StateCheckerSetup(world_.scene(), robot_, arm_.dofs)),
        links_(model_.linksMovedBy(arm_.dofs)),
        q_(scene->robots[robot_].q_start) {
    linkPoses(model_, scene->robots[robot_].X_WB, q_, X_WL_);
    for (const BodyId body : IdRange<BodyId>(world_.scene().bodies())) {
      X_WBody_.push_back(world_.pose(body));
    }
  }

  CheckedScene checkedScene() const {
    CheckedScene checked;
    const CollisionScene& bodies = world_.scene();
    checked.shapes.resize(static_cast<std::size_t>(bodies.bodies()));
    for (std::size_t r = 0; r < scene_->robots.size(); ++r) {
      const auto& links = scene_->robots[r].model->links;
      for (std::size_t l = 0; l < links.size(); ++l) {
        const BodyId body = bodies.linkBody(RobotId(r), LinkId(l));
        if (body.valid()) checked.shapes[body] = links[l].collision;
      }
    }
    for (std::size_t o = 0; o < scene_->objects.size(); ++o) {
      const BodyId body = bodies.objectBody(ObjectId(o));
      checked.shapes[body] = scene_->objects[o].shapes;
    }
    checked.X_WBody = X_WBody_;
    checked.moving = checker_.moving();
    checked.pairs = BodyPairs(bodies.bodies());
    for (const auto& [a, b] : checker_.pairs().pairs()) checked.pairs.insert(a, b);
    return checked;
  }

  Eigen::VectorXd randomState(std::mt19937_64& random) const {
    Eigen::VectorXd q(static_cast<Eigen::Index>(arm_.dofs.size()));
    for (std::size_t i = 0; i < arm_.joints.size(); ++i) {
      const Joint& joint = model_.joints[arm_.joints[i]];
      q[static_cast<Eigen::Index>(i)] =
          std::uniform_real_distribution(joint.lower, joint.upper)(random);
    }
    return q;
  }

  bool valid(const Eigen::VectorXd& q) { return checker_.valid(q); }

  /// By a reference: the arm's links by our forward kinematics, then the reference's verdict.
  bool validBy(ReferenceChecker& reference, const Eigen::VectorXd& q) {
    for (std::size_t i = 0; i < arm_.dofs.size(); ++i) {
      q_[arm_.dofs[i].value()] = q[static_cast<Eigen::Index>(i)];
    }
    linkPosesOf(model_, q_, links_, X_WL_);
    for (const LinkId link : links_) {
      const BodyId body = world_.scene().linkBody(robot_, link);
      if (body.valid()) X_WBody_[body] = X_WL_[link];
    }
    return reference.valid(X_WBody_);
  }

 private:
  std::shared_ptr<const Scene> scene_;
  RobotId robot_;
  const RobotModel& model_;
  const Arm& arm_;
  CollisionWorld world_;
  StateChecker checker_;
  std::vector<LinkId> links_;
  RobotVector q_;
  std::vector<Pose> X_WL_;
  std::vector<Pose> X_WBody_;
};

/// Verdicts may differ where the margins alone touch (2 mm; FCL's shapes have none).
constexpr double kMostDiffering = 0.05;

struct Contestants {
  MovingArm& arm;
  ReferenceChecker &fcl, &bullet;
};

/// A row for each reference over these states.
void addRows(const Contestants& all, const std::string& title,
             const std::vector<Eigen::VectorXd>& states, int rounds, Report& report) {
  int fcl_differs = 0, bullet_differs = 0;
  for (const auto& q : states) {
    const bool valid = all.arm.valid(q);
    fcl_differs += all.arm.validBy(all.fcl, q) != valid ? 1 : 0;
    bullet_differs += all.arm.validBy(all.bullet, q) != valid ? 1 : 0;
  }
  const double most = std::max(1.0, kMostDiffering * static_cast<double>(states.size()));
  if (fcl_differs > most || bullet_differs > most) {
    throw std::runtime_error(title + ": verdicts differ in " + std::to_string(fcl_differs) +
                             " (FCL) and " + std::to_string(bullet_differs) + " (Bullet) of " +
                             std::to_string(states.size()) + " states: not the same work");
  }
  const auto every = [&states](const auto& valid) {
    for (const auto& q : states) benchmark::DoNotOptimize(valid(q));
  };
  const auto times = medianRounds(
      rounds, {[&] { every([&](const auto& q) { return all.arm.valid(q); }); },
               [&] { every([&](const auto& q) { return all.arm.validBy(all.fcl, q); }); },
               [&] { every([&](const auto& q) { return all.arm.validBy(all.bullet, q); }); }});
  const double to_us = 1e6 / static_cast<double>(states.size());
  report.rows.push_back({title + " (FCL)", times[0] * to_us, times[1] * to_us,
                         "FCL, convex shapes, AABB trees", "us"});
  report.rows.push_back({title + " (Bullet)", times[0] * to_us, times[2] * to_us,
                         "Bullet performDiscreteCollisionDetection", "us"});
  report.notes.push_back(title + ": of " + std::to_string(states.size()) +
                         " verdicts, other than ours: FCL " + std::to_string(fcl_differs) +
                         ", Bullet " + std::to_string(bullet_differs) + ".");
}

Report statesOf(const std::shared_ptr<const Scene>& scene, const ArmName& name,
                const Effort& effort) {
  MovingArm arm(scene, name);
  const CheckedScene checked = arm.checkedScene();
  const auto fcl = makeFclChecker(checked), bullet = makeBulletChecker(checked);
  std::mt19937_64 random(2014);
  std::vector<Eigen::VectorXd> any, free;
  while (static_cast<int>(any.size()) < effort.states ||
         static_cast<int>(free.size()) < effort.states) {
    Eigen::VectorXd q = arm.randomState(random);
    if (static_cast<int>(any.size()) < effort.states) any.push_back(q);
    if (static_cast<int>(free.size()) < effort.states && arm.valid(q)) free.push_back(q);
  }
  Report report;
  const Contestants all{arm, *fcl, *bullet};
  const std::string title = std::string("state of ") + name.title;
  addRows(all, title + ", random", any, effort.rounds, report);
  addRows(all, title + ", free", free, effort.rounds, report);
  return report;
}

}  // namespace

Report stateBench(const std::shared_ptr<const Scene>& scene, const Effort& effort) {
  Report report;
  for (const ArmName& arm : kArms) report.add(statesOf(scene, arm, effort));
  return report;
}

}  // namespace handover::bench
