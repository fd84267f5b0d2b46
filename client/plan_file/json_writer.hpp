// SPDX-License-Identifier: Apache-2.0
// JSON text with doubles written shortest-exact and keys in the order they were set.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace handover::client {

using Json = nlohmann::ordered_json;

/// One line.
std::string compact(const Json& json);
/// Indented by two; lists of plain values, and whatever fits into 100 characters, on one line.
std::string pretty(const Json& json);

}  // namespace handover::client
