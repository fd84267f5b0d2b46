// SPDX-License-Identifier: Apache-2.0
// Which links of a robot can touch at all, by sampling: for robots whose SRDF does not say.
#pragma once

#include "core/model/robot_model.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace handover {

enum class TouchPattern { kNever, kSometimes, kAlways };

/// How often two links touched in `samples` random postures.
struct LinkPairTouch {
  LinkId link_a, link_b;  ///< link_a < link_b
  TouchPattern pattern = TouchPattern::kNever;
  int touching = 0;
};

/// Every pair of links that have shapes and are not adjacent, in order; the SRDF's disabled pairs
/// are sampled like the others. Postures are uniform within the joints' limits. The same seed gives
/// the same answer. @pre samples > 0.
std::vector<LinkPairTouch> sampleSelfCollision(const RobotModel& model, int samples,
                                               std::uint64_t seed);

}  // namespace handover
