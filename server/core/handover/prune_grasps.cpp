// SPDX-License-Identifier: Apache-2.0
#include "core/handover/prune_grasps.hpp"

#include <algorithm>
#include <numeric>

namespace handover {
namespace {

std::string robotOf(const std::string& body) { return body.substr(0, body.find('/')); }

void tally(const CollisionScene& names, const BodyPair& hit, RejectTally& rejects) {
  const std::string& a = names.name(hit.first);
  const std::string& b = names.name(hit.second);
  const bool self = a.find('/') != std::string::npos && b.find('/') != std::string::npos &&
                    robotOf(a) == robotOf(b);
  rejects.add(self ? "self_collision" : "collision", {a, b});
}

}  // namespace

const FeasibleGrasp* PrunedGrasps::find(int grasp) const {
  const auto found =
      std::lower_bound(kept.begin(), kept.end(), grasp,
                       [](const FeasibleGrasp& a, int index) { return a.grasp < index; });
  return found != kept.end() && found->grasp == grasp ? &*found : nullptr;
}

double travelTime(const Manipulator& role, const ArmVector& from, const ArmVector& to) {
  return ((to - from).cwiseAbs().array() / role.kinematics->velocity().array()).maxCoeff();
}

PrunedGrasps pruneGrasps(const Manipulator& role, const CollisionScene& names, const Pose& X_WO,
                         const std::vector<int>& candidates, const ConfigurationCost& cost,
                         GraspTest& test, const PruneEffort& effort, const Deadline& deadline) {
  const std::size_t most = effort.configurations;
  std::vector<int> all(candidates);
  if (all.empty()) {
    all.resize(role.grasps->grasps.size());
    std::iota(all.begin(), all.end(), 0);
  }
  PrunedGrasps pruned;
  IkQuery query;
  query.swivel_samples = effort.swivels;
  query.q_near = role.armOf(role.placed->q_start);
  std::vector<ArmVector> solutions;
  std::vector<std::pair<double, std::size_t>> order;
  for (const int index : all) {
    if (deadline.over()) break;
    ++pruned.tested;
    const Grasp& grasp = role.grasps->grasps[static_cast<std::size_t>(index)];
    const Pose X_WT = X_WO * grasp.X_OT;
    const Pose X_AT = role.worldToArm(X_WT);
    // Cheap tests before dear ones: is there any configuration, is the hand free, then all of them.
    const IkCounts counts =
        role.kinematics->visit(X_AT, query, [](const ArmVector&) { return false; });
    if (counts.solutions == 0) {
      pruned.rejects.add(counts.limits > 0 ? "limits" : "no_ik");
      continue;
    }
    if (const auto hit = test.handTouches(grasp, X_WT)) {
      tally(names, *hit, pruned.rejects);
      continue;
    }
    solutions.clear();
    role.kinematics->solve(X_AT, query, solutions);
    order.clear();
    for (std::size_t i = 0; i < solutions.size(); ++i) {
      order.emplace_back(cost(index, solutions[i]), i);
    }
    std::sort(order.begin(), order.end());
    const std::size_t tried = std::min(most, order.size());
    std::size_t first = 0;
    std::optional<BodyPair> first_hit;
    for (; first < tried; ++first) {
      const auto hit = test.armTouches(grasp, solutions[order[first].second]);
      if (!hit) break;
      if (!first_hit) first_hit = hit;
    }
    if (first == tried) {
      tally(names, *first_hit, pruned.rejects);
      continue;
    }
    FeasibleGrasp feasible;
    feasible.grasp = index;
    feasible.manipulability = role.kinematics->manipulability(solutions[order[first].second]);
    for (std::size_t i = first; i < order.size() && i < first + most; ++i) {
      feasible.configurations.push_back(solutions[order[i].second]);
    }
    pruned.kept.push_back(std::move(feasible));
  }
  return pruned;
}

}  // namespace handover
