// SPDX-License-Identifier: Apache-2.0
// A process that was stopped for longer than a lease (a debugger, a suspended machine, SIGSTOP) was
// forgotten by its peers, but finds their last datagrams still waiting and goes on with them as
// before. Fast DDS numbers what a pair says to each other from their first meeting on: the peer
// begins anew, the sleeper goes on, and each passes over what the other says as old, for good.
#pragma once

#include <atomic>
#include <chrono>

namespace handover::wire {

/// After this time without a datagram peers forget a participant.
constexpr std::chrono::seconds kParticipantLease{3};

/// Neither sends nor receives after a sleep until everybody must have forgotten each other: what
/// follows is a first meeting. Methods are safe from any thread.
class SleepSilence {
 public:
  using Duration = std::chrono::nanoseconds;

  /// Announcements go out every 0.2 s, and the last one to a peer may be older than the last one at
  /// all.
  static constexpr Duration kSleep = kParticipantLease - std::chrono::milliseconds{500};
  static constexpr Duration kSilence = kParticipantLease + std::chrono::milliseconds{500};

  explicit SleepSilence(Duration now = sinceBoot()) : sent_at_(now.count()) {}

  /// Whether a datagram may go out, or in.
  bool maySend(Duration now = sinceBoot());
  bool mayReceive(Duration now = sinceBoot());

  /// Counts what a machine is suspended, as its peers' clocks do.
  static Duration sinceBoot();

 private:
  bool over(Duration now) const { return now.count() >= silent_until_; }

  std::atomic<Duration::rep> sent_at_;
  std::atomic<Duration::rep> silent_until_{0};
};

}  // namespace handover::wire
