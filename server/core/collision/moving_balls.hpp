// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/collision/collision_scene.hpp"

#include <vector>

namespace handover {

/// Puts a ball round all that moves with a group, margins included: the groups' bounds of travel
/// are of these.
void setBalls(const CollisionScene& scene, const std::vector<MovingBody>& bodies,
              RigidGroups& groups);

}  // namespace handover
