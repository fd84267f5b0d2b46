// SPDX-License-Identifier: Apache-2.0
// What a client asks for, as plain values. Units: m, rad, s.
#pragma once

#include <handover/common/enum_names.hpp>
#include <handover/common/pose.hpp>
#include <handover/common/request_id.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover {

/// Stop at the first plan · the best found within the budget · every tuple, counted as the paper.
enum class SearchMode { kUnspecified = 0, kFirst, kBest, kAll };

/// The paper's candidates only · widened after them.
enum class SearchWidth { kUnspecified = 0, kPaper, kWide };

/// What the best plan is the best at (design §7). Only `dexterity` is built.
enum class Objective { kUnspecified = 0, kBalanced, kTime, kDexterity };

template <>
struct EnumNames<SearchMode> {
  static constexpr std::array value{"unspecified", "first", "best", "all"};
};

template <>
struct EnumNames<SearchWidth> {
  static constexpr std::array value{"unspecified", "paper", "wide"};
};

template <>
struct EnumNames<Objective> {
  static constexpr std::array value{"unspecified", "balanced", "time", "dexterity"};
};

/// A change of the cell for one request: PATH = keys of the cell file joined by dots, VALUE = YAML.
struct Override {
  std::string path;
  std::string value;
  bool operator==(const Override&) const = default;
};

/// In a request's chain, alone: the planner chooses the holders.
inline constexpr const char* kAutoChain = "auto";

/// A deadline from here on is none [s]: clocks would overflow on absurd ones.
inline constexpr double kLongestDeadline = 86'400;

/// One transport, as a client asks for it.
struct PlanRequest {
  RequestId id;
  std::string client_id;  ///< [a-z0-9_-]{1,64}
  std::string cell;
  std::string task;  ///< empty: object and goal are given below
  std::string object;
  std::optional<PoseValue> X_WO_goal;
  /// A holder each, `robot` or `robot/arm`, in the order in which they hold the object; kAutoChain
  /// alone; empty: the task's.
  std::vector<std::string> chain;
  std::vector<Override> overrides;
  std::optional<std::uint64_t> expected_revision;  ///< rejected when the scene has another one
  std::string expected_hash;                       ///< likewise; empty: any
  SearchMode mode = SearchMode::kBest;
  SearchWidth search = SearchWidth::kWide;
  Objective objective = Objective::kUnspecified;  ///< unspecified: the task's, else the default
  std::uint64_t seed = 1;
  std::optional<double> deadline_s;  ///< from the daemon's acceptance; see kLongestDeadline
  double speed_scale = 1.0;          ///< in (0, 1]: slows the timing, not the path
  double slack_s = 0;                ///< lateness of each stage that the plan tolerates [s]
  bool wants_fix = true;             ///< of a failure: what would help is sought
  bool operator==(const PlanRequest&) const = default;
};

}  // namespace handover
