// SPDX-License-Identifier: Apache-2.0
// A transport before timing: for every stage a polyline over some joints of one robot, and the
// world that it happens in.
#pragma once

#include "core/planning/collision_context.hpp"
#include "core/planning/grasp_feasibility.hpp"

#include <optional>
#include <vector>

namespace handover {

/// A gripper's joints that move while the arm does.
struct FingerMotion {
  Eigen::VectorXd from, to;
};

struct StagePath {
  TaskStage stage;
  const Manipulator* mover = nullptr;
  std::vector<DofId> dofs;  ///< of the mover's robot, as the waypoints list them
  std::vector<Eigen::VectorXd> waypoints;
  std::optional<FingerMotion> fingers;  ///< of a reach
  CellState state;                      ///< everything as the stage begins
};

/// One holder's part.
struct HolderPath {
  const Manipulator* manipulator = nullptr;
  int grasp = -1;
  Dexterity dexterity;  ///< at the configurations that the stages reach
};

struct TransportPath {
  std::vector<StagePath> stages;  ///< in the order of makeStages()
  std::vector<HolderPath> holders;
  std::vector<Pose> X_WH;  ///< per handover
};

/// One holder's grasp where it takes the object and where it gives it.
struct HolderGrasp {
  FeasibleGrasp take, give;
};

/// [paper] Alg. 2, for a chain: one of the set ℋ.
struct TransportTuple {
  std::vector<Pose> X_WH;            ///< per handover
  std::vector<HolderGrasp> holders;  ///< one more
};

}  // namespace handover
