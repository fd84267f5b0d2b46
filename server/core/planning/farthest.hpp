// SPDX-License-Identifier: Apache-2.0
// Of everything that a search looked at, the candidate that came farthest: what a failure shows.
#pragma once

#include <handover/common/plan_event.hpp>

#include <compare>
#include <cstdint>
#include <optional>

namespace handover {

/// Where a candidate fell, in the order of the search.
enum class SearchStep {
  kNothing,
  kTake,         ///< the first holder's grasp, O at its start
  kGive,         ///< the last holder's grasp, O at its goal
  kBothReach,    ///< a handover pose, by both arms' IK alone
  kReceive,      ///< the receiver's grasp there
  kApproach,     ///< its straight approach
  kGiverBeside,  ///< the giver's grasp, with the receiver's hand in place
  kHandsMeet,    ///< both hands coming and leaving
  kMotions,      ///< a stage's motion
  kTiming,       ///< the timed curves
};

/// How far a candidate came: the step, then how far within it.
struct SearchProgress {
  SearchStep step = SearchStep::kNothing;
  std::uint32_t within = 0;
  auto operator<=>(const SearchProgress&) const = default;
};

/// Keeps the first of those that came farthest.
class FarthestCandidate {
 public:
  /// @param make  called only where the candidate is kept.
  template <typename Make>
  void offer(const SearchProgress& progress, const Make& make) {
    if (progress <= progress_) return;
    progress_ = progress;
    candidate_ = make();
  }

  const std::optional<Farthest>& candidate() const { return candidate_; }

 private:
  SearchProgress progress_;
  std::optional<Farthest> candidate_;
};

}  // namespace handover
