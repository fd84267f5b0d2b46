// SPDX-License-Identifier: Apache-2.0
// Locks that clang checks: a member says by which mutex it is guarded, a function which one its
// caller has to hold, and the preset `clang` (-Wthread-safety) refuses whatever breaks that. Other
// compilers see plain standard locks.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#ifdef __clang__
#define HANDOVER_THREAD_SAFETY(attribute) __attribute__((attribute))
#else
#define HANDOVER_THREAD_SAFETY(attribute)
#endif

/// Of a member: read and written only with that mutex held.
#define HANDOVER_GUARDED_BY(mutex) HANDOVER_THREAD_SAFETY(guarded_by(mutex))
/// Of a function, or of a lambda that a wait calls: called only with that mutex held.
#define HANDOVER_REQUIRES(mutex) HANDOVER_THREAD_SAFETY(requires_capability(mutex))
/// Of a function: takes that mutex itself, so that its caller must not hold it.
#define HANDOVER_EXCLUDES(mutex) HANDOVER_THREAD_SAFETY(locks_excluded(mutex))

namespace handover {

class HANDOVER_THREAD_SAFETY(capability("mutex")) Mutex {
 public:
  void lock() HANDOVER_THREAD_SAFETY(acquire_capability()) { mutex_.lock(); }

  void unlock() HANDOVER_THREAD_SAFETY(release_capability()) { mutex_.unlock(); }

 private:
  friend class MutexLock;

  std::mutex mutex_;
};

/// Holds a mutex to the end of its scope, or until unlock().
class HANDOVER_THREAD_SAFETY(scoped_lockable) MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) HANDOVER_THREAD_SAFETY(acquire_capability(mutex))
      : lock_(mutex.mutex_) {}

  ~MutexLock() HANDOVER_THREAD_SAFETY(release_capability()) = default;
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

  void lock() HANDOVER_THREAD_SAFETY(acquire_capability()) { lock_.lock(); }

  void unlock() HANDOVER_THREAD_SAFETY(release_capability()) { lock_.unlock(); }

 private:
  friend class Condition;

  std::unique_lock<std::mutex> lock_;
};

/// A condition variable for MutexLock. Waits give the mutex away meanwhile and hold it again when
/// they return. A predicate that reads guarded members says so:
/// `changed.wait(lock, [&]() HANDOVER_REQUIRES(mutex) { return done; })`.
class Condition {
 public:
  void notify_one() { changed_.notify_one(); }

  void notify_all() { changed_.notify_all(); }

  void wait(MutexLock& lock) { changed_.wait(lock.lock_); }

  template <typename Predicate>
  void wait(MutexLock& lock, Predicate predicate) {
    changed_.wait(lock.lock_, predicate);
  }

  template <typename Duration>
  void wait_for(MutexLock& lock, Duration most) {
    changed_.wait_for(lock.lock_, most);
  }

  /// What the predicate says in the end.
  template <typename Duration, typename Predicate>
  bool wait_for(MutexLock& lock, Duration most, Predicate predicate) {
    return changed_.wait_for(lock.lock_, most, predicate);
  }

  template <typename TimePoint>
  void wait_until(MutexLock& lock, TimePoint until) {
    changed_.wait_until(lock.lock_, until);
  }

  /// What the predicate says in the end.
  template <typename TimePoint, typename Predicate>
  bool wait_until(MutexLock& lock, TimePoint until, Predicate predicate) {
    return changed_.wait_until(lock.lock_, until, predicate);
  }

 private:
  std::condition_variable changed_;
};

}  // namespace handover
