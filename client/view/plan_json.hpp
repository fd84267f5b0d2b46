// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/geometry.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace handover::view {

/// The JSON of a plan file (format handover-plan/2), its members not yet looked at: reading one
/// that is missing or of another type throws nlohmann::json::exception.
/// @throws Unreadable when the text is none.
nlohmann::json parsePlanFile(const std::string& text);

Pose poseOf(const nlohmann::json& pose);

/// @throws Unreadable for a type that the format does not have.
Geometry geometryOf(const nlohmann::json& geometry);

}  // namespace handover::view
