// SPDX-License-Identifier: Apache-2.0
// What the runs of an experiment change: drawn from a cell's variations.
#pragma once

#include "plan_file/json_writer.hpp"

#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <cstdint>
#include <vector>

namespace handover::ctl {

/// Which draw of which experiment.
struct DrawId {
  std::uint64_t seed = 1;  ///< the experiment's
  std::uint64_t run = 0;
  std::uint64_t again = 0;  ///< how often this run was drawn before
};

/// Override path -> value as JSON, in the order of the variations. Depends on the arguments alone,
/// so that a run can be repeated without those before it.
/// @param stretch  scales ranges about their middles; 0: the middles themselves.
client::Json draw(const std::vector<Variation>& variations, const DrawId& id, double stretch);

/// The same as a request says it: each value as the text that `plan --set` takes.
std::vector<Override> overridesOf(const client::Json& drawn);

}  // namespace handover::ctl
