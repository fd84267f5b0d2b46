// SPDX-License-Identifier: Apache-2.0
#include "dds/sender_pool.hpp"

#include "runtime/thread_name.hpp"

#include <handover/common/log.hpp>

namespace handover {

SenderPool::SenderPool(int threads) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this, i] { loop(i); });
}

SenderPool::~SenderPool() { stop(); }

void SenderPool::post(Job job) {
  {
    const MutexLock lock(mutex_);
    if (stopping_) return;
    jobs_.push_back(std::move(job));
  }
  changed_.notify_one();
}

void SenderPool::stop() {
  std::deque<Job> dropped;  // what they own ends without the lock
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    dropped.swap(jobs_);
  }
  changed_.notify_all();
  threads_.clear();  // joins
}

void SenderPool::loop(int index) noexcept {
  nameThread("send-" + std::to_string(index));
  while (true) {
    Job job;
    {
      MutexLock lock(mutex_);
      changed_.wait(lock,
                    [this]() HANDOVER_REQUIRES(mutex_) { return stopping_ || !jobs_.empty(); });
      if (stopping_) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    try {
      job();
    } catch (const std::exception& error) {
      logger("dds")->error("sending: {}", error.what());
    }
  }
}

}  // namespace handover
