// SPDX-License-Identifier: Apache-2.0
// A writer for as many instances as it may hold, then another one.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/mutex.hpp>

#include <functional>
#include <memory>

namespace handover::client {

/// Hands out writers. Unregistering an instance of a living writer can spin the receive thread of
/// Fast DDS 2.9.1, and what was disposed leaves holes that it tells every reader of at every write:
/// a writer that has had its share ends when the last who holds it lets go. The next one is made at
/// half of the share, so that it has matched by then.
template <typename Message>
class WriterLease {
 public:
  using WriterPtr = std::shared_ptr<wire::Writer<Message>>;

  explicit WriterLease(std::function<WriterPtr()> make) : make_(std::move(make)) {}

  /// For one more instance. @throws wire::DdsError.
  WriterPtr next() {
    WriterPtr ended;  // without the lock
    const MutexLock lock(mutex_);
    if (current_ == nullptr) current_ = make_();
    if (used_ == kShare / 2) next_ = make_();
    if (used_ == kShare) {
      ended = std::exchange(current_, std::move(next_));
      used_ = 0;
    }
    ++used_;
    return current_;
  }

 private:
  static constexpr int kShare = 32;

  const std::function<WriterPtr()> make_;
  Mutex mutex_;
  WriterPtr current_ HANDOVER_GUARDED_BY(mutex_), next_ HANDOVER_GUARDED_BY(mutex_);
  int used_ HANDOVER_GUARDED_BY(mutex_) = 0;
};

}  // namespace handover::client
