// SPDX-License-Identifier: Apache-2.0
#include <handover/client/plan_motion.hpp>

#include <algorithm>
#include <iterator>

namespace handover::client {
namespace {

/// A joint at a sample.
JointState at(const StageTrajectory& stage, std::size_t sample, std::size_t column) {
  return {stage.q[sample][column], stage.qd[sample][column], stage.qdd[sample][column]};
}

/// The quintic through two states `h` seconds apart, at `s` in [0, h]. Its coefficients are those
/// of the polynomial in s / h about the first state.
JointState quintic(const JointState& a, const JointState& b, double h, double s) {
  const double v0 = a.qd * h, v1 = b.qd * h, a0 = a.qdd * h * h, a1 = b.qdd * h * h;
  const double rest = b.q - a.q - v0 - 0.5 * a0;  // what is left for the higher terms
  const double slope = v1 - v0 - a0, bend = a1 - a0;
  const double c3 = 10 * rest - 4 * slope + 0.5 * bend;
  const double c4 = -15 * rest + 7 * slope - bend;
  const double c5 = 6 * rest - 3 * slope + 0.5 * bend;
  const double u = s / h;
  return {a.q + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
          (v0 + u * (a0 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h,
          (a0 + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (h * h)};
}

double endOf(const StageTrajectory& stage) { return stage.start + stage.t.back(); }

}  // namespace

JointState sampleStage(const StageTrajectory& stage, std::size_t column, double s) {
  if (s <= stage.t.front()) return at(stage, 0, column);
  if (s >= stage.t.back()) return at(stage, stage.t.size() - 1, column);
  const auto above = std::upper_bound(stage.t.begin(), stage.t.end(), s);
  const auto i = static_cast<std::size_t>(std::distance(stage.t.begin(), above)) - 1;
  if (s == stage.t[i]) return at(stage, i, column);
  return quintic(at(stage, i, column), at(stage, i + 1, column), stage.t[i + 1] - stage.t[i],
                 s - stage.t[i]);
}

PlanMotion::PlanMotion(PlanFile file) : file_(std::move(file)) {
  if (!file_.scene) throw PlanFileError("/scene", "is null");
  if (!file_.plan) throw PlanFileError("/plan", "is null");
  const auto& robots = file_.scene->robots;
  for (const RobotSnapshot& robot : robots) uses_.emplace_back(robot.q_start.size());
  for (std::size_t i = 0; i < file_.plan->stages.size(); ++i) {
    const StageTrajectory& stage = file_.plan->stages[i];
    const std::string where = "/plan/stages/" + std::to_string(i);
    const auto robot = std::find_if(robots.begin(), robots.end(),
                                    [&](const auto& it) { return it.name == stage.robot; });
    if (robot == robots.end()) throw PlanFileError(where + "/robot", "is not in the scene");
    auto& of_robot = uses_[static_cast<std::size_t>(std::distance(robots.begin(), robot))];
    for (std::size_t column = 0; column < stage.joints.size(); ++column) {
      const auto& q = robot->q_start;
      const auto joint = std::find_if(
          q.begin(), q.end(), [&](const auto& it) { return it.first == stage.joints[column]; });
      if (joint == q.end()) {
        throw PlanFileError(where + "/joints", "'" + stage.joints[column] + "' is not in q_start");
      }
      of_robot[static_cast<std::size_t>(std::distance(q.begin(), joint))].push_back({i, column});
    }
    duration_ = std::max(duration_, endOf(stage));
  }
  const auto earlier = [this](const Use& a, const Use& b) {
    return file_.plan->stages[a.stage].start < file_.plan->stages[b.stage].start;
  };
  for (auto& of_robot : uses_) {
    for (auto& uses : of_robot) std::stable_sort(uses.begin(), uses.end(), earlier);
  }
}

std::vector<JointState> PlanMotion::sample(std::size_t robot, double t) const {
  const auto& q_start = file_.scene->robots.at(robot).q_start;
  std::vector<JointState> states;
  for (std::size_t joint = 0; joint < q_start.size(); ++joint) {
    const auto& uses = uses_[robot][joint];
    const auto begun = [&](const Use& use) { return file_.plan->stages[use.stage].start <= t; };
    const auto next = std::partition_point(uses.begin(), uses.end(), begun);
    if (next == uses.begin()) {
      states.push_back({q_start[joint].second, 0, 0});
      continue;
    }
    const Use& last = *std::prev(next);
    const StageTrajectory& stage = file_.plan->stages[last.stage];
    states.push_back(sampleStage(stage, last.column, t - stage.start));
    // A joint that no running stage moves stands still.
    if (t > endOf(stage)) states.back() = {states.back().q, 0, 0};
  }
  return states;
}

std::vector<std::size_t> PlanMotion::running(double t) const {
  std::vector<std::size_t> stages;
  for (std::size_t i = 0; i < file_.plan->stages.size(); ++i) {
    const StageTrajectory& stage = file_.plan->stages[i];
    if (stage.start <= t && t < endOf(stage)) stages.push_back(i);
  }
  return stages;
}

}  // namespace handover::client
