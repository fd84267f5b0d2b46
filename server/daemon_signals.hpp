// SPDX-License-Identifier: Apache-2.0
// What a daemon is told by signals.
#pragma once

#include <handover/common/deadline.hpp>
#include <handover/common/mutex.hpp>

#include <signal.h>

#include <atomic>
#include <deque>
#include <thread>

namespace handover {

/// Takes SIGTERM and SIGINT (stop), SIGHUP (read the cells again), SIGUSR1 and SIGUSR2 (nothing)
/// from the calling thread and all that it starts from then on. From the first stop signal on the
/// process has kLongestStop: whatever it hangs in, it ends then.
class DaemonSignals {
 public:
  static constexpr unsigned kLongestStop = 4;  ///< [s]; with the end itself within the 5 promised

  /// For commands that serve nothing: signals end them, those too that waited since the start.
  static void leaveThem();

  /// Signals that waited since the program was started count too, once per sort.
  DaemonSignals();
  ~DaemonSignals();
  DaemonSignals(const DaemonSignals&) = delete;
  DaemonSignals& operator=(const DaemonSignals&) = delete;

  /// Waits for the next stop signal or SIGHUP, in the order of their coming.
  int wait();

  /// What a stop that hangs exits with: 0 unless said. From any thread.
  static void setExitOfHang(int code);

  /// Cancelled by the first stop signal.
  const Deadline& stopping() const { return stopping_; }

 private:
  void loop() noexcept;

  sigset_t set_;
  const Deadline stopping_;
  std::atomic<bool> ending_ = false;
  Mutex mutex_;
  Condition came_;
  std::deque<int> signals_ HANDOVER_GUARDED_BY(mutex_);
  std::jthread thread_;
};

}  // namespace handover
