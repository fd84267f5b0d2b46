// SPDX-License-Identifier: Apache-2.0
// What a plan file (format handover-plan/2) says, as values. Units: m, rad, s.
#pragma once

#include <handover/common/plan_event.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace handover::client {

/// A solution and its stages, in the order of their `index`.
struct Plan {
  Solution solution;
  std::vector<StageTrajectory> stages;
  bool operator==(const Plan&) const = default;
};

/// What the file does not carry keeps its default: grasp indices, and the indices of solutions.
/// Timing and funnel are not read.
struct PlanFile {
  std::optional<SceneSnapshot> scene;  ///< nullopt: it failed before its scene was known
  std::optional<Plan> plan;            ///< nullopt: it failed; with its quality, where known
  bool complete = false;               ///< false: a deadline cut the search
  std::uint64_t scene_revision = 0;
  std::optional<Failure> failure;  ///< why there is no plan
  bool operator==(const PlanFile&) const = default;
};

/// The text is no plan file, or its file cannot be read.
class PlanFileError : public std::runtime_error {
 public:
  /// @param where a JSON pointer into the file, or the file's path.
  PlanFileError(const std::string& where, const std::string& what)
      : std::runtime_error((where.empty() ? "/" : where) + ": " + what) {}
};

/// Reads and checks form: types, finite numbers, unit quaternions (1e-3), sizes, names of robots,
/// rows as long as `joints`, indices in order. Whether the plan is a good one is not asked.
/// @throws PlanFileError naming the field as a JSON pointer.
PlanFile parsePlanFile(std::string_view text);

/// The text of a regular file of at most 256 MiB. @throws PlanFileError.
std::string readPlanText(const std::filesystem::path& file);

/// Both. @throws PlanFileError naming the file, and the field in it.
PlanFile readPlanFile(const std::filesystem::path& file);

}  // namespace handover::client
