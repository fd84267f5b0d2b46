// SPDX-License-Identifier: Apache-2.0
// Fewer grasps out of many, keeping the strong and the varied.
#pragma once

#include "core/grasp/grasp_set.hpp"

#include <vector>

namespace handover {

/// True if two grasps are within both `spacing` [m] and `angle` [rad] of each other.
bool tooClose(const Grasp& a, const Grasp& b, double spacing, double angle);

/// Picks `wanted` of the grasps: first the best one, then again and again the one for which
/// distance to those chosen x quality^(1/2) is greatest (farthest points, weighted). Distance is
/// sqrt(|dp|^2 + (0.08 m * angle)^2) of the tool poses. The order of generation is kept; ties fall
/// to the earlier one. All are kept if there are no more than `wanted`.
std::vector<Grasp> thin(const std::vector<Grasp>& grasps, int wanted);

}  // namespace handover
