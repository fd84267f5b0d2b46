// SPDX-License-Identifier: Apache-2.0
// Counts of why candidates fell, for the funnel and for explanations.
#pragma once

#include <handover/common/plan_event.hpp>

#include <map>
#include <string>
#include <vector>

namespace handover {

class RejectTally {
 public:
  void add(const std::string& cause, std::uint32_t count = 1) { add(cause, {}, count); }

  /// The pair's names are put in alphabetical order.
  void add(const std::string& cause, NamePair pair, std::uint32_t count = 1);
  void add(const RejectTally& other);

  /// Most frequent first, ties by name; at most `limit` colliding pairs, the rest summed up under
  /// the cause without a pair.
  std::vector<RejectCount> counts(std::size_t limit = 5) const;
  std::uint32_t total() const;

 private:
  std::map<std::pair<std::string, NamePair>, std::uint32_t> counts_;
};

}  // namespace handover
