// SPDX-License-Identifier: Apache-2.0
#include "wire/sleep_silence.hpp"

#include <ctime>

namespace handover::wire {

bool SleepSilence::maySend(Duration now) {
  const Duration before{sent_at_.exchange(now.count())};
  if (now - before >= kSleep) silent_until_ = (now + kSilence).count();
  return over(now);
}

bool SleepSilence::mayReceive(Duration now) {
  return over(now) && now - Duration{sent_at_} < kSleep;
}

SleepSilence::Duration SleepSilence::sinceBoot() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds{now.tv_sec} + std::chrono::nanoseconds{now.tv_nsec};
}

}  // namespace handover::wire
