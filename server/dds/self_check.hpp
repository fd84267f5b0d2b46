// SPDX-License-Identifier: Apache-2.0
// Whether the daemon can be reached, for as long as it runs.
#pragma once

#include <handover/common/mutex.hpp>

#include <chrono>
#include <functional>
#include <thread>

namespace handover {

/// Probes every two seconds from a thread of its own.
class SelfCheck {
 public:
  struct Settings {
    /// A round trip; false after a time of its own.
    std::function<bool()> probe;
    /// After each that came back: feeds a watchdog.
    std::function<void()> on_alive = [] {};
    /// Once, when none has come back for `patience`.
    std::function<void()> on_deaf = [] {};
    std::chrono::milliseconds period{2000};
    std::chrono::milliseconds patience{15'000};
  };

  explicit SelfCheck(Settings settings);
  ~SelfCheck();  ///< waits for the probe under way
  SelfCheck(const SelfCheck&) = delete;
  SelfCheck& operator=(const SelfCheck&) = delete;

 private:
  void loop() noexcept;
  /// False: that was it.
  bool check(std::chrono::steady_clock::time_point& heard);

  const Settings settings_;
  Mutex mutex_;
  Condition changed_;
  bool stopping_ HANDOVER_GUARDED_BY(mutex_) = false;
  std::jthread thread_;
};

}  // namespace handover
