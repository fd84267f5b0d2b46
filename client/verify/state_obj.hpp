// SPDX-License-Identifier: Apache-2.0
// One moment of a plan as triangles, to look at what a plan really does.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace handover::verify {

/// "start" and "end" of the plan, a stage by its index ("7"), or by its action and holder
/// ("grasp.1").
bool namesState(std::string_view kind);

/// The whole cell at the end of that stage, or of the plan, as a Wavefront file: the collision
/// shapes of every link (`o robot/link`) and object (`o name`), in the world, metres, z up.
/// @pre namesState(kind).
/// @throws Unreadable when the plan or a file that it names cannot be understood, or when its
/// stages have no meaning together.
std::string stateObj(std::string_view plan_text, const std::filesystem::path& root,
                     std::string_view kind);

}  // namespace handover::verify
