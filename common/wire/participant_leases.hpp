// SPDX-License-Identifier: Apache-2.0
// Watches the leases of the participants that are heard, in Fast DDS 2.9.1's stead. Its own timers
// look for a lease on one thread while another removes the participant, which says that it leaves:
// an assertion (PDP::check_remote_participant_liveliness, in later versions too), or whoever took
// the place of the old participant is removed. Here every lease that is announced is made endless
// before the library reads it, so that those timers never run, and who was silent for its lease is
// let go as if it had said that it leaves: all on the receiving thread.
#pragma once

#include "wire/submessages.hpp"

#include <handover/common/mutex.hpp>

#include <chrono>
#include <map>
#include <set>
#include <vector>

namespace handover::wire {

/// Methods are safe from any thread.
class ParticipantLeases {
 public:
  using Clock = std::chrono::steady_clock;
  using Datagram = std::vector<std::uint8_t>;
  /// Where datagrams come in: discovery has ports of its own.
  using Channel = const void*;

  /// What a datagram means for leases.
  struct Heard {
    /// Announces a participant in a way that could not be ended: without a lease, as somebody else,
    /// without saying that it announces itself, in fragments. Not for the library.
    bool unendable = false;
    /// The datagram with endless leases; empty when it announces nobody.
    Datagram endless;
  };

  /// Notes who speaks in `datagram`, which came through `channel`, as heard.
  Heard hear(std::span<const std::uint8_t> datagram, Channel channel,
             Clock::time_point now = Clock::now());

  /// Of each participant that was silent for its lease, or longest when there are too many, and was
  /// announced through `channel`, that it leaves. Each is said once, and the participant forgotten.
  /// A process that was itself stopped for so long lets all go, as they let it go: both sides begin
  /// anew then.
  std::vector<Datagram> departures(Channel channel, Clock::time_point now = Clock::now());

  /// Of participants that are known.
  std::size_t size() const;

 private:
  struct Known {
    Clock::time_point heard;
    std::chrono::microseconds lease{};
    std::int64_t last_sample = 0;  ///< of its announcements
    std::set<Channel> channels;
  };

  using Participants = std::map<GuidPrefix, Known>;

  Known& know(const GuidPrefix& prefix, Clock::time_point now) HANDOVER_REQUIRES(mutex_);
  void depart(Participants::iterator gone) HANDOVER_REQUIRES(mutex_);
  void departSilent(Clock::time_point now) HANDOVER_REQUIRES(mutex_);

  mutable Mutex mutex_;
  Participants known_ HANDOVER_GUARDED_BY(mutex_);
  std::map<Channel, std::vector<Datagram>> departures_ HANDOVER_GUARDED_BY(mutex_);
  Clock::time_point looked_ HANDOVER_GUARDED_BY(mutex_);
};

}  // namespace handover::wire
