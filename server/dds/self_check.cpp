// SPDX-License-Identifier: Apache-2.0
#include "dds/self_check.hpp"

#include "runtime/thread_name.hpp"

#include <handover/common/log.hpp>

namespace handover {

using Clock = std::chrono::steady_clock;

SelfCheck::SelfCheck(Settings settings)
    : settings_(std::move(settings)), thread_([this] { loop(); }) {}

SelfCheck::~SelfCheck() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
}

bool SelfCheck::check(Clock::time_point& heard) {
  if (settings_.probe()) {
    heard = Clock::now();
    settings_.on_alive();
    return true;
  }
  const auto silent = Clock::now() - heard;
  logger("dds")->warn("nobody can reach this daemon: its own probe has not come back for {:.0f} s",
                      std::chrono::duration<double>(silent).count());
  if (silent < settings_.patience) return true;
  settings_.on_deaf();
  return false;
}

void SelfCheck::loop() noexcept {
  nameThread("probe");
  auto heard = Clock::now();
  while (true) {
    {
      MutexLock lock(mutex_);
      const bool stop = changed_.wait_for(lock, settings_.period,
                                          [this]() HANDOVER_REQUIRES(mutex_) { return stopping_; });
      if (stop) return;
    }
    if (!check(heard)) return;
  }
}

}  // namespace handover
