// SPDX-License-Identifier: Apache-2.0
// What the verifier found.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace handover::verify {

struct Violation {
  std::string stage;                ///< its kind; empty: of the plan as a whole
  int index = -1;                   ///< place in `stages`, -1 for the plan as a whole
  double time = 0;                  ///< [s] from the plan's start
  std::string kind;                 ///< a word: collision, velocity, join, ...
  std::string what;                 ///< a sentence for people
  std::vector<std::string> bodies;  ///< `robot/link` or object, for contacts
};

/// How much was looked at, so that "valid" can be weighed.
struct StageChecks {
  std::string stage;
  std::size_t states = 0;   ///< times at which body poses were computed
  std::size_t pairs = 0;    ///< pairs that could meet
  std::size_t queries = 0;  ///< exact contact or distance questions
  /// Least distance that was measured between bodies that must not touch [m]; infinite: all of them
  /// stayed farther apart than was worth measuring.
  double clearance = std::numeric_limits<double>::infinity();
};

struct Report {
  std::vector<Violation> violations;
  std::vector<StageChecks> stages;

  bool valid() const { return violations.empty(); }
};

/// One line per violation: stage, time, kind, what.
std::string toText(const Report& report);
/// {"valid", "violations": [...], "checks": {...}} in one line.
std::string toJson(const Report& report);
/// The same shape for a plan that could not be read.
std::string unreadableJson(const std::string& what);

}  // namespace handover::verify
