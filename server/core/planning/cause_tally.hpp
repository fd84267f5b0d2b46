// SPDX-License-Identifier: Apache-2.0
// Counts of why candidates fell, for the funnel and for explanations.
#pragma once

#include <handover/common/plan_event.hpp>

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace handover {

class CauseTally {
 public:
  void add(Cause cause, std::uint32_t count = 1) { add(cause, NamePair{}, count); }

  /// The pair's names are put in alphabetical order, an empty one last.
  void add(Cause cause, NamePair pair, std::uint32_t count = 1);
  /// Of a motion: where it struck.
  void add(Cause cause, StageRef stage, NamePair pair = {});
  void add(const CauseTally& other);

  /// Most frequent first, ties by order of the enumeration and names; at most `limit` pairs, then
  /// those of other pairs, summed up under the cause without a pair.
  std::vector<CauseCount> counts(std::size_t limit = 5) const;
  std::uint32_t total() const;

 private:
  struct Key {
    Cause cause;
    NamePair pair;
    std::optional<StageRef> stage;
    auto operator<=>(const Key&) const = default;
  };

  std::map<Key, std::uint32_t> counts_;
};

}  // namespace handover
