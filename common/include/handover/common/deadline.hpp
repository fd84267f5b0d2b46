// SPDX-License-Identifier: Apache-2.0
// Cancel and deadline as one value, polled by every loop that can be long.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>

namespace handover {

/// Cheap to copy; copies share the cancel flag. Safe from any thread.
class Deadline {
 public:
  using Clock = std::chrono::steady_clock;

  enum class State { kOpen, kCancelled, kPassed };

  /// Never passes until cancelled.
  Deadline() : cancelled_(std::make_shared<std::atomic<bool>>(false)) {}

  explicit Deadline(Clock::time_point at) : Deadline() { at_ = at; }

  void cancel() const { cancelled_->store(true, std::memory_order_relaxed); }

  State state() const {
    if (cancelled_->load(std::memory_order_relaxed)) return State::kCancelled;
    if (at_ && Clock::now() >= *at_) return State::kPassed;
    return State::kOpen;
  }

  /// True when work should stop.
  bool over() const { return state() != State::kOpen; }

 private:
  std::shared_ptr<std::atomic<bool>> cancelled_;
  std::optional<Clock::time_point> at_;
};

}  // namespace handover
