// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <handover/common/status.hpp>

#include <cstddef>
#include <deque>
#include <optional>

namespace handover {

/// How long the last answers took. Not safe from several threads.
class RecentTimes {
 public:
  static constexpr std::size_t kMost = 256;

  void add(double seconds);
  /// By rank: the median of an even number is the lower one of its two. None before the first.
  std::optional<AnswerTimes> summary() const;

 private:
  std::deque<double> seconds_;
};

}  // namespace handover
