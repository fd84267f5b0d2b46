// SPDX-License-Identifier: Apache-2.0
#include "wire/participant_leases.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace handover::wire {
namespace {

using namespace std::chrono_literals;
using Bytes = std::span<const std::uint8_t>;
using EntityId = std::array<std::uint8_t, 4>;
using Guid = std::array<std::uint8_t, 16>;

constexpr EntityId kAnnouncer{0, 1, 0, 0xc2}, kParticipant{0, 0, 1, 0xc1};  // RTPS 2.3, 9.3.1.5

enum Parameter : std::uint16_t {
  kLease = 0x02,
  kGuid = 0x50,
  kBuiltinEndpoints = 0x58,
  kKeyHash = 0x70,
};

/// Between looks for those that were silent.
constexpr auto kLook = 50ms;
/// A domain has at most 120 participants of a machine; who is heard stays.
constexpr std::size_t kMostParticipants = 4'096;

Guid guidOf(const GuidPrefix& prefix) { return wire::guidOf(prefix, kParticipant); }

bool isAnnouncer(Bytes writer) {
  return std::equal(kAnnouncer.begin(), kAnnouncer.end(), writer.begin());
}

/// What a participant says of itself.
struct Announcement {
  std::chrono::microseconds lease{};
  std::vector<std::size_t> leases;  ///< where, from the payload's begin
  bool little = false, own = true, named = false, announces = false;
};

std::chrono::microseconds leaseAt(Bytes value, bool little) {
  const auto seconds = static_cast<std::int32_t>(numberAt(value, 0, 4, little));
  const std::uint64_t fraction = numberAt(value, 4, 4, little);
  return std::max(0s, std::chrono::seconds(seconds)) +
         std::chrono::microseconds(fraction * 1'000'000 >> 32);
}

/// Takes one parameter, whose value is at `at`; false when it does not have its length.
bool take(Announcement& into, std::uint16_t id, Bytes value, std::size_t at, const Guid& speaker) {
  switch (id) {
    case kLease:
      into.lease = leaseAt(value, into.little);
      into.leases.push_back(at);
      return value.size() == 8;
    case kGuid:
    case kKeyHash:
      into.named = into.named || id == kGuid;
      into.own = into.own && std::equal(value.begin(), value.end(), speaker.begin(), speaker.end());
      return true;
    case kBuiltinEndpoints:
      into.announces = (numberAt(value, 0, 4, into.little) & 1) != 0;
      return value.size() == 4;
    default:
      return true;
  }
}

/// The parameter list of `payload`; nullopt when the library would not find its end.
std::optional<Announcement> announcementIn(Bytes payload, const Guid& speaker) {
  constexpr std::uint8_t kBigEndian = 2, kLittleEndian = 3;
  if (payload.size() < 4 || (payload[1] != kBigEndian && payload[1] != kLittleEndian)) {
    return std::nullopt;
  }
  Announcement found;
  found.little = payload[1] == kLittleEndian;
  for (std::size_t at = 4; at + 4 <= payload.size();) {
    const auto id = static_cast<std::uint16_t>(numberAt(payload, at, 2, found.little));
    const std::size_t length = numberAt(payload, at + 2, 2, found.little);
    if (id == kSentinelId) return found;
    at += 4;
    if (length > payload.size() - at) return std::nullopt;
    if (!take(found, id, payload.subspan(at, length), at, speaker)) return std::nullopt;
    at += (length + 3) / 4 * 4;
  }
  return std::nullopt;
}

bool endable(const Announcement& announcement) {
  return announcement.named && announcement.own && announcement.announces &&
         !announcement.leases.empty();
}

/// The longest that is, in the byte order of the list.
void makeEndless(std::span<std::uint8_t> lease, bool little) {
  std::fill(lease.begin(), lease.begin() + 8, std::uint8_t{0xff});
  lease[little ? 3 : 0] = 0x7f;
}

void append(std::vector<std::uint8_t>& to, Bytes bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

/// As the participant itself would say it: its announcement disposed and unregistered.
std::vector<std::uint8_t> departure(const GuidPrefix& prefix, std::int64_t sample) {
  const auto number = static_cast<std::uint64_t>(sample);
  std::vector<std::uint8_t> bytes{'R', 'T', 'P', 'S', 2, 3, 0, 0};
  append(bytes, prefix);
  // Data, big-endian, with inline QoS of 32 bytes and nothing else; to any reader.
  append(bytes, std::to_array<std::uint8_t>({kDataId, kInlineQosFlag, 0, kDataMembers + 32}));
  append(bytes, std::to_array<std::uint8_t>({0, 0, 0, 16, 0, 0, 0, 0}));
  append(bytes, kAnnouncer);
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  }
  append(bytes, std::to_array<std::uint8_t>({0, kKeyHash, 0, 16}));
  append(bytes, guidOf(prefix));
  append(bytes, std::to_array<std::uint8_t>({0, 0x71, 0, 4, 0, 0, 0, 3}));
  append(bytes, std::to_array<std::uint8_t>({0, kSentinelId, 0, 0}));
  return bytes;
}

/// An announcement in a datagram.
struct Announced {
  Announcement announcement;
  GuidPrefix from{};
  std::int64_t sample = 0;
  std::size_t payload = 0;  ///< where in the datagram
};

/// What a submessage announces; `unendable` is set when nobody could end it.
std::optional<Announced> announcedBy(const Submessage& submessage, Bytes datagram,
                                     bool& unendable) {
  const bool whole = submessage.id == kDataId;
  if (!whole && submessage.id != kDataFragId) return std::nullopt;
  if (submessage.content.size() < kDataMembers) return std::nullopt;
  if (!isAnnouncer(submessage.content.subspan(8, 4))) return std::nullopt;
  if (whole && (submessage.flags & kWithDataFlag) == 0) return std::nullopt;  // it leaves
  const auto payload = whole ? payloadOf(submessage, kDataMembers) : std::nullopt;
  const auto found =
      payload ? announcementIn(submessage.content.subspan(*payload), guidOf(submessage.from))
              : std::nullopt;
  if (!found || !endable(*found)) {
    unendable = true;
    return std::nullopt;
  }
  const auto begin = static_cast<std::size_t>(submessage.content.data() - datagram.data());
  return Announced{*found, submessage.from, submessage.sequenceAt(12), begin + *payload};
}

}  // namespace

ParticipantLeases::Heard ParticipantLeases::hear(Bytes datagram, Channel channel,
                                                 Clock::time_point now) {
  Heard heard;
  std::vector<Announced> announced;
  std::set<GuidPrefix> speakers;
  forEachSubmessage(datagram, [&](const Submessage& submessage, bool) {
    speakers.insert(submessage.from);
    auto found = announcedBy(submessage, datagram, heard.unendable);
    if (found) announced.push_back(std::move(*found));
  });
  const MutexLock lock(mutex_);
  for (const GuidPrefix& speaker : speakers) {
    const auto found = known_.find(speaker);
    if (found != known_.end()) found->second.heard = now;
  }
  if (heard.unendable || announced.empty()) return heard;
  heard.endless.assign(datagram.begin(), datagram.end());
  for (const Announced& each : announced) {
    Known& known = know(each.from, now);
    known.lease = each.announcement.lease;
    known.last_sample = std::max(known.last_sample, each.sample);
    known.channels.insert(channel);
    for (const std::size_t lease : each.announcement.leases) {
      makeEndless(std::span(heard.endless).subspan(each.payload + lease), each.announcement.little);
    }
  }
  return heard;
}

ParticipantLeases::Known& ParticipantLeases::know(const GuidPrefix& prefix, Clock::time_point now) {
  const auto found = known_.find(prefix);
  if (found != known_.end()) return found->second;
  if (known_.size() >= kMostParticipants) {
    depart(std::min_element(known_.begin(), known_.end(), [](const auto& a, const auto& b) {
      return a.second.heard < b.second.heard;
    }));
  }
  Known& made = known_[prefix];
  made.heard = now;
  return made;
}

void ParticipantLeases::depart(Participants::iterator gone) {
  const auto& [prefix, known] = *gone;
  for (const Channel channel : known.channels) {
    departures_[channel].push_back(departure(prefix, known.last_sample + 1));
  }
  known_.erase(gone);
}

void ParticipantLeases::departSilent(Clock::time_point now) {
  if (now < looked_ + kLook) return;
  looked_ = now;
  for (auto it = known_.begin(); it != known_.end();) {
    const auto next = std::next(it);
    if (now - it->second.heard > it->second.lease) depart(it);
    it = next;
  }
}

std::vector<ParticipantLeases::Datagram> ParticipantLeases::departures(Channel channel,
                                                                       Clock::time_point now) {
  const MutexLock lock(mutex_);
  departSilent(now);
  const auto found = departures_.find(channel);
  if (found == departures_.end()) return {};
  std::vector<Datagram> taken = std::move(found->second);
  departures_.erase(found);
  return taken;
}

std::size_t ParticipantLeases::size() const {
  const MutexLock lock(mutex_);
  return known_.size();
}

}  // namespace handover::wire
