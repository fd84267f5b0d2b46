// SPDX-License-Identifier: Apache-2.0
// What the verifier found.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace handover::verify {

struct Violation {
  int stage = -1;                   ///< index, -1 for the plan as a whole
  double time = 0;                  ///< [s] from the plan's start
  std::string kind;                 ///< the rule in a word: contact, velocity, join, ...
  std::string what;                 ///< a sentence for people
  std::vector<std::string> bodies;  ///< `robot/link` or object, for contacts
};

/// How much was looked at, so that "valid" can be weighed.
struct Effort {
  std::size_t states = 0;   ///< times at which body poses were computed
  std::size_t pairs = 0;    ///< pairs that could meet, summed over stretches of time
  std::size_t queries = 0;  ///< exact contact or distance questions
};

struct MeasuredClearance {
  double least = 0;  ///< [m], at most 0.05
  int stage = -1;
  std::vector<std::string> pair;  ///< empty at 0.05
};

/// The verifier's own figures. Clearances are sought only when they are asked for.
struct MeasuredQuality {
  double duration = 0, bound = 0, object = 0;  ///< [s]
  std::map<std::string, double> idle;          ///< [s]
  std::map<std::string, MeasuredClearance> clearance;
  double tilt_deg = 0, turn_deg = 0, least_turn_deg = 0;
  std::optional<double> limit_margin;
  double jerk_share = 0;
};

struct Report {
  std::vector<Violation> violations;
  std::vector<std::string> stage_names;  ///< for the text
  Effort nominal, in_turn, late;
  std::optional<MeasuredQuality> quality;

  void add(Violation violation) { violations.push_back(std::move(violation)); }

  bool valid() const { return violations.empty(); }
};

/// One line per violation: stage, time, kind, what.
std::string toText(const Report& report);
/// {"valid", "violations": [...], "checks": {...}, "quality"} in one line.
std::string toJson(const Report& report);
/// The same shape for a plan that could not be read.
std::string unreadableJson(const std::string& what);

}  // namespace handover::verify
