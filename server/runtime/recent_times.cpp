// SPDX-License-Identifier: Apache-2.0
#include "runtime/recent_times.hpp"

#include <algorithm>
#include <vector>

namespace handover {

void RecentTimes::add(double seconds) {
  seconds_.push_back(seconds);
  if (seconds_.size() > kMost) seconds_.pop_front();
}

std::optional<AnswerTimes> RecentTimes::summary() const {
  if (seconds_.empty()) return std::nullopt;
  std::vector<double> sorted(seconds_.begin(), seconds_.end());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t last = sorted.size() - 1;
  return AnswerTimes{1e3 * sorted[last / 2], 1e3 * sorted[last * 95 / 100]};
}

}  // namespace handover
