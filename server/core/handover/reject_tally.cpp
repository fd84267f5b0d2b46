// SPDX-License-Identifier: Apache-2.0
#include "core/handover/reject_tally.hpp"

#include <algorithm>

namespace handover {

void RejectTally::add(const std::string& cause, NamePair pair, std::uint32_t count) {
  if (count == 0) return;
  if (pair.second < pair.first) std::swap(pair.first, pair.second);
  counts_[{cause, std::move(pair)}] += count;
}

void RejectTally::add(const RejectTally& other) {
  for (const auto& [key, count] : other.counts_) counts_[key] += count;
}

std::vector<RejectCount> RejectTally::counts(std::size_t limit) const {
  std::vector<RejectCount> sorted;
  for (const auto& [key, count] : counts_) sorted.push_back({key.first, key.second, count});
  const auto more = [](const RejectCount& a, const RejectCount& b) { return a.count > b.count; };
  std::stable_sort(sorted.begin(), sorted.end(), more);

  std::vector<RejectCount> result;
  std::map<std::string, std::uint32_t> rest;
  std::size_t pairs = 0;
  for (auto& entry : sorted) {
    const bool named = !entry.pair.first.empty() || !entry.pair.second.empty();
    if (named && ++pairs > limit) {
      rest[entry.cause] += entry.count;
    } else {
      result.push_back(std::move(entry));
    }
  }
  for (const auto& [cause, count] : rest) result.push_back({cause, {}, count});
  std::stable_sort(result.begin(), result.end(), more);
  return result;
}

std::uint32_t RejectTally::total() const {
  std::uint32_t sum = 0;
  for (const auto& [key, count] : counts_) sum += count;
  return sum;
}

}  // namespace handover
