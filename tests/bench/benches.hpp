// SPDX-License-Identifier: Apache-2.0
// The parts of the bench. Each does the same work by us and by the reference, on the robots and in
// the cell as shipped.
#pragma once

#include "core/model/scene.hpp"
#include "report.hpp"

namespace handover::bench {

/// How much of everything: enough for steady medians, or just enough to see that it runs.
struct Effort {
  int rounds = 7;
  int requests = 30;      ///< plans of the butler
  int pings = 300;        ///< round trips
  int poses = 1000;       ///< of IK
  int states = 2000;      ///< of collision
  int samples = 200'000;  ///< of a reachability map
};

/// An arm as robots and cells name it.
struct ArmName {
  const char *robot, *arm, *title;
};

inline constexpr ArmName kArms[] = {{"crichton", "right", "Crichton's LWA4"},
                                    {"hubo", "left", "Hubo's arm"}};

/// The butler cell's start.
std::shared_ptr<const Scene> butlerScene();

/// §IV-E over DDS, by a daemon with one worker, beside the paper's figure; and what DDS itself
/// takes.
Report daemonBench(const Effort& effort);
/// First solution within limits for poses that are reached, beside KDL.
Report ikBench(const Scene& scene, const Effort& effort);
/// One arm's state against the whole cell and its own robot, beside FCL and Bullet.
Report stateBench(const std::shared_ptr<const Scene>& scene, const Effort& effort);
/// §IV-A, beside the loop as one would write it first.
Report mapBench(const Scene& scene, const Effort& effort);

}  // namespace handover::bench
