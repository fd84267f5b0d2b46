// SPDX-License-Identifier: Apache-2.0
// One moment of a plan as triangles, to look at what a plan really does.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace handover::ctl {

/// Whether it names a moment: "start" or "end" of the plan, or the end of a stage, by its index
/// ("7") or its action and holder ("grasp.1").
bool namesState(const std::string& kind);

/// The whole cell at that moment as a Wavefront file: the collision shapes of every link (`o
/// robot/link`) and object (`o name`), in the world, metres, z up.
/// @param root folder that the plan's paths are relative to.
/// @throws client::PlanFileError when the plan or a file that it names cannot be read, and when the
/// plan has no such stage.
/// @pre namesState(kind).
std::string stateObj(std::string_view plan_text, const std::filesystem::path& root,
                     const std::string& kind);

}  // namespace handover::ctl
