// SPDX-License-Identifier: Apache-2.0
#include "core/planning/cause_tally.hpp"

#include <algorithm>

namespace handover {
namespace {

NamePair sorted(NamePair pair) {
  const bool swap = pair.first.empty() || (!pair.second.empty() && pair.second < pair.first);
  if (swap) std::swap(pair.first, pair.second);
  return pair;
}

}  // namespace

void CauseTally::add(Cause cause, NamePair pair, std::uint32_t count) {
  if (count > 0) counts_[{cause, sorted(std::move(pair)), {}}] += count;
}

void CauseTally::add(Cause cause, StageRef stage, NamePair pair) {
  ++counts_[{cause, sorted(std::move(pair)), stage}];
}

void CauseTally::add(const CauseTally& other) {
  for (const auto& [key, count] : other.counts_) counts_[key] += count;
}

std::vector<CauseCount> CauseTally::counts(std::size_t limit) const {
  std::vector<CauseCount> all;
  for (const auto& [key, count] : counts_) all.push_back({key.cause, key.pair, key.stage, count});
  const auto more = [](const CauseCount& a, const CauseCount& b) { return a.count > b.count; };
  std::stable_sort(all.begin(), all.end(), more);

  std::vector<CauseCount> result;
  std::map<std::pair<Cause, std::optional<StageRef>>, std::uint32_t> rest;
  std::size_t pairs = 0;
  for (CauseCount& entry : all) {
    const bool named = !entry.pair.first.empty();
    if (named && ++pairs > limit) {
      rest[{entry.cause, entry.stage}] += entry.count;
    } else {
      result.push_back(std::move(entry));
    }
  }
  const auto others = static_cast<std::ptrdiff_t>(result.size());
  for (const auto& [key, count] : rest) result.push_back({key.first, {}, key.second, count});
  std::stable_sort(result.begin() + others, result.end(), more);
  return result;
}

std::uint32_t CauseTally::total() const {
  std::uint32_t sum = 0;
  for (const auto& [key, count] : counts_) sum += count;
  return sum;
}

}  // namespace handover
