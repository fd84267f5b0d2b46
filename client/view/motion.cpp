// SPDX-License-Identifier: Apache-2.0
#include "view/motion.hpp"

#include "view/unreadable.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>

namespace handover::view {
namespace {

using Json = nlohmann::json;

Stage stageOf(const Json& json, std::size_t holders) {
  Stage stage;
  json.at("holder").get_to(stage.holder);
  json.at("action").get_to(stage.action);
  json.at("robot").get_to(stage.robot);
  json.at("joints").get_to(stage.joints);
  json.at("start").get_to(stage.start);
  json.at("t").get_to(stage.t);
  json.at("q").get_to(stage.q);
  json.at("qd").get_to(stage.qd);
  json.at("qdd").get_to(stage.qdd);
  const auto fits = [&](const std::vector<std::vector<double>>& rows) {
    const auto row_fits = [&](const auto& row) { return row.size() == stage.joints.size(); };
    return rows.size() == stage.t.size() && std::all_of(rows.begin(), rows.end(), row_fits);
  };
  if (stage.t.size() < 2 || !fits(stage.q) || !fits(stage.qd) || !fits(stage.qdd) ||
      stage.holder >= holders) {
    throw Unreadable("/plan/stages", "samples, joints and holders do not match");
  }
  return stage;
}

/// Position at u in [0, 1] of the quintic between two samples h apart.
double quintic(double u, double h, const std::array<double, 3>& from,
               const std::array<double, 3>& to) {
  const double d = to[0] - from[0], v = from[1] * h, w = to[1] * h;
  const double a = from[2] * h * h, b = to[2] * h * h;
  const double c3 = 10 * d - 6 * v - 4 * w - 1.5 * a + 0.5 * b;
  const double c4 = -15 * d + 8 * v + 7 * w + 1.5 * a - b;
  const double c5 = 6 * d - 3 * (v + w) + 0.5 * (b - a);
  return from[0] + u * (v + u * (a / 2 + u * (c3 + u * (c4 + u * c5))));
}

}  // namespace

std::vector<double> Stage::positionsAt(double s) const {
  if (s <= 0) return q.front();
  if (s >= t.back()) return q.back();
  const auto k = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), s) - t.begin());
  const double h = t[k] - t[k - 1], u = (s - t[k - 1]) / h;
  std::vector<double> positions;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    positions.push_back(
        quintic(u, h, {q[k - 1][j], qd[k - 1][j], qdd[k - 1][j]}, {q[k][j], qd[k][j], qdd[k][j]}));
  }
  return positions;
}

Motion::Motion(const Json& plan) {
  holds_.resize(plan.at("holders").size());
  for (const Json& stage : plan.at("stages")) stages_.push_back(stageOf(stage, holds_.size()));
  std::stable_sort(stages_.begin(), stages_.end(),
                   [](const Stage& a, const Stage& b) { return a.start < b.start; });
  for (const Stage& stage : stages_) {
    if (stage.action == "grasp") holds_[stage.holder].from = stage.end();
    if (stage.action == "release") holds_[stage.holder].to = stage.end();
  }
}

double Motion::duration() const {
  double end = 0;
  for (const Stage& stage : stages_) end = std::max(end, stage.end());
  return end;
}

Positions Motion::jointsAt(const std::string& robot, Positions q, double time) const {
  for (const Stage& stage : stages_) {
    if (stage.start > time) break;
    if (stage.robot != robot) continue;
    const std::vector<double> positions = stage.positionsAt(time - stage.start);
    for (std::size_t j = 0; j < positions.size(); ++j) q[stage.joints[j]] = positions[j];
  }
  return q;
}

}  // namespace handover::view
