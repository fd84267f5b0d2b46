// SPDX-License-Identifier: Apache-2.0
// A few threads for what must not happen on Fast DDS's: making, using and deleting writers.
#pragma once

#include <handover/common/mutex.hpp>

#include <deque>
#include <functional>
#include <thread>
#include <vector>

namespace handover {

/// Runs jobs in the order of posting. Safe from any thread.
class SenderPool {
 public:
  using Job = std::function<void()>;

  explicit SenderPool(int threads);
  ~SenderPool();  ///< stop()
  SenderPool(const SenderPool&) = delete;
  SenderPool& operator=(const SenderPool&) = delete;

  /// An exception that leaves the job is logged. Nothing after stop().
  void post(Job job);
  /// Waits for the jobs that run; those that wait are dropped.
  void stop();

 private:
  void loop(int index) noexcept;

  Mutex mutex_;
  Condition changed_;
  std::deque<Job> jobs_ HANDOVER_GUARDED_BY(mutex_);
  bool stopping_ HANDOVER_GUARDED_BY(mutex_) = false;
  std::vector<std::jthread> threads_;
};

}  // namespace handover
