// SPDX-License-Identifier: Apache-2.0
#include <handover/common/mutex.hpp>

#include <gtest/gtest.h>

#include <thread>

namespace handover {
namespace {

using namespace std::chrono_literals;

class Gate {
 public:
  void open() {
    const MutexLock lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

  /// False if nobody opened it.
  bool waitFor(std::chrono::milliseconds most) {
    MutexLock lock(mutex_);
    return changed_.wait_for(lock, most, [this]() HANDOVER_REQUIRES(mutex_) { return open_; });
  }

 private:
  Mutex mutex_;
  Condition changed_;
  bool open_ HANDOVER_GUARDED_BY(mutex_) = false;
};

TEST(Condition, AWaitGivesTheMutexAwayAndEndsWhenItIsTrue) {
  Gate gate;
  const std::jthread other([&] { gate.open(); });  // needs the mutex while the other one waits
  EXPECT_TRUE(gate.waitFor(20s));
}

TEST(Condition, AWaitInVainSaysSo) {
  Gate gate;
  EXPECT_FALSE(gate.waitFor(1ms));
  gate.open();
  EXPECT_TRUE(gate.waitFor(0ms));
}

TEST(MutexLock, IsFreeForOthersAfterUnlock) {
  Mutex mutex;
  int count = 0;
  MutexLock lock(mutex);
  lock.unlock();
  std::jthread([&] {
    const MutexLock other(mutex);
    ++count;
  }).join();
  lock.lock();
  EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace handover
