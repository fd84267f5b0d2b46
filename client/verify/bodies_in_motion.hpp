// SPDX-License-Identifier: Apache-2.0
// What each body moves with.
#pragma once

#include "verify/motion.hpp"

#include <vector>

namespace handover::verify {

/// The link that a body moves with; robot -1: it stands.
struct Mount {
  int robot = -1, link = -1;
  Pose X_LB = Pose::Identity();  ///< of the body in the link; in the world where it stands
};

/// Of a body other than O.
Mount mountOf(const Scene& scene, int body);
/// Of O in the hand of a holder.
Mount mountInHand(const Scene& scene, int holder);
/// Of O at a time.
Mount mountOfObject(const Motion& motion, double T);

/// Index into Task::actors of the actor that moves the link, or -1.
int actorOfLink(const Scene& scene, const Task& task, int robot, int link);

}  // namespace handover::verify
