// SPDX-License-Identifier: Apache-2.0
#include "wire/packet_guard.hpp"

#include "wire/participant_leases.hpp"
#include "wire/submessages.hpp"

#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include <algorithm>
#include <vector>

namespace handover::wire {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using Bytes = std::span<const std::uint8_t>;

/// A gap's samples are walked one by one: a millisecond's worth.
constexpr std::int64_t kLongestGap = 65'536;
/// As are those before a heartbeat's first, from those that the reader had been told of, by each
/// reader of the writer: 5 ns a sample. What a writer's first may be at all, then, when it is heard
/// the first time (90 ms, once): readers that come late walk from 0. Our own writers are replaced
/// far earlier (status: after 65,536 samples), or keep their first sample (discovery), or write one
/// request each. A foreign client that keeps one request writer gets there in half a year of a
/// request a second.
constexpr std::int64_t kFarthestFirst = 1 << 24;
/// Later a heartbeat comes with every few samples, or at least in the 3 s of a lease: no writer of
/// ours writes 1,000 samples a second. A tenth of a millisecond; more for one not heard for long
/// (its reader, or this process, had been stopped), so that it is heard again.
constexpr std::int64_t kLongestJump = 16'384, kJumpPerSecond = 1'000;
/// Whoever sends in the names of more writers than there ever are makes all be heard anew.
constexpr std::size_t kMostWriters = 4'096;
/// Of any sample: a million a second would take eight years.
constexpr std::int64_t kFarthestSample = std::int64_t{1} << 48;
/// The smallest fragment anybody cuts (Cyclone DDS: 1344), with room; the largest sample of ours.
constexpr std::uint32_t kSmallestFragment = 64, kLargestSample = 64 << 20;

/// After the ids of reader and writer: first sample, base of the list.
std::optional<PacketFault> gapFault(const Submessage& gap) {
  if (gap.content.size() < 28) return PacketFault::kLength;
  const std::int64_t first = gap.sequenceAt(8), base = gap.sequenceAt(16);
  if (first <= 0 || base <= 0 || base - first > kLongestGap) return PacketFault::kGap;
  return std::max(first, base) <= kFarthestSample ? std::nullopt
                                                  : std::optional(PacketFault::kSequence);
}

/// After the ids of reader and writer: first and last sample, count.
std::optional<PacketFault> heartbeatFault(const Submessage& heartbeat) {
  if (heartbeat.content.size() < 28) return PacketFault::kLength;
  const std::int64_t first = heartbeat.sequenceAt(8);
  if (first <= 0 || first > kFarthestFirst) return PacketFault::kHeartbeat;
  return heartbeat.sequenceAt(16) <= kFarthestSample ? std::nullopt
                                                     : std::optional(PacketFault::kSequence);
}

/// After the ids of reader and writer: the sample.
std::optional<PacketFault> heartbeatFragmentFault(const Submessage& heartbeat) {
  if (heartbeat.content.size() < 24) return PacketFault::kLength;
  return heartbeat.sequenceAt(8) <= kFarthestSample ? std::nullopt
                                                    : std::optional(PacketFault::kSequence);
}

/// After flags, offset and the ids of reader and writer: the sample.
bool numberedTooFar(const Submessage& data) { return data.sequenceAt(12) > kFarthestSample; }

std::optional<PacketFault> dataFault(const Submessage& data) {
  if (data.content.size() < kDataMembers) return PacketFault::kLength;
  if (numberedTooFar(data)) return PacketFault::kSequence;
  return payloadOf(data, kDataMembers) ? std::nullopt : std::optional(PacketFault::kData);
}

/// After the members of data: number of the first fragment (from 1), how many, their size, the
/// sample's.
std::optional<PacketFault> fragmentFault(const Submessage& data) {
  if (data.content.size() < 32) return PacketFault::kLength;
  if (numberedTooFar(data)) return PacketFault::kSequence;
  const auto payload = payloadOf(data, 32);
  if (!payload) return PacketFault::kData;
  const std::uint64_t first = data.longAt(20), count = data.shortAt(24), size = data.shortAt(26);
  const std::uint64_t sample = data.longAt(28);
  if (first == 0 || count == 0 || size < kSmallestFragment || sample > kLargestSample) {
    return PacketFault::kFragment;
  }
  const std::uint64_t from = (first - 1) * size;
  const std::uint64_t bytes = from < sample ? std::min(count * size, sample - from) : 0;
  const bool whole = bytes > 0 && data.content.size() - *payload >= bytes;
  return whole ? std::nullopt : std::optional(PacketFault::kFragment);
}

std::optional<PacketFault> faultOf(const Submessage& submessage) {
  switch (submessage.id) {
    case kGapId:
      return gapFault(submessage);
    case kHeartbeatId:
      return heartbeatFault(submessage);
    case kHeartbeatFragId:
      return heartbeatFragmentFault(submessage);
    case kDataId:
      return dataFault(submessage);
    case kDataFragId:
      return fragmentFault(submessage);
    default:
      return std::nullopt;
  }
}

/// What a heartbeat says is its writer's first sample.
struct SaidFirst {
  std::array<std::uint8_t, 16> writer{};
  std::int64_t first = 0;
};

/// @pre `datagram` has no fault.
std::vector<SaidFirst> heartbeatsOf(Bytes datagram) {
  std::vector<SaidFirst> found;
  forEachSubmessage(datagram, [&](const Submessage& submessage, bool) {
    if (submessage.id != kHeartbeatId) return;
    found.push_back(
        {guidOf(submessage.from, submessage.content.subspan(4, 4)), submessage.sequenceAt(8)});
  });
  return found;
}

bool fromEprosima(Bytes datagram) { return datagram[6] == 0x01 && datagram[7] == 0x0f; }

class GuardedTransport final : public rtps::ChainingTransport {
 public:
  GuardedTransport(const rtps::ChainingTransportDescriptor& descriptor,
                   std::shared_ptr<GuardWatch> watch)
      : ChainingTransport(descriptor), watch_(std::move(watch)) {}

  rtps::TransportDescriptorInterface* get_configuration() override {
    return low_level_transport_->get_configuration();
  }

  bool send(eprosima::fastrtps::rtps::SenderResource* below,
            const eprosima::fastrtps::rtps::octet* data, std::uint32_t size,
            eprosima::fastrtps::rtps::LocatorsIterator* begin,
            eprosima::fastrtps::rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& until) override {
    return below->send(data, size, begin, end, until);
  }

  void receive(rtps::TransportReceiverInterface* next, const eprosima::fastrtps::rtps::octet* data,
               std::uint32_t size, const eprosima::fastrtps::rtps::Locator_t& local,
               const eprosima::fastrtps::rtps::Locator_t& remote) override {
    const auto pass = [&](Bytes datagram) {
      watch_->watch([&] {
        next->OnDataReceived(datagram.data(), static_cast<std::uint32_t>(datagram.size()), local,
                             remote);
      });
    };
    // First: who speaks now may have been let go meanwhile, and is met anew.
    for (const auto& departure : leases_.departures(next)) pass(departure);
    const Bytes datagram{data, size};
    const bool faulty = guard_.fault(datagram).has_value();
    const auto heard = faulty ? ParticipantLeases::Heard{} : leases_.hear(datagram, next);
    if (faulty || heard.unendable) {
      ++watch_->dropped;
    } else {
      pass(heard.endless.empty() ? datagram : heard.endless);
    }
  }

 private:
  PacketGuard guard_;
  ParticipantLeases leases_;
  const std::shared_ptr<GuardWatch> watch_;
};

struct GuardedDescriptor final : public rtps::ChainingTransportDescriptor {
  GuardedDescriptor(std::shared_ptr<rtps::TransportDescriptorInterface> below,
                    std::shared_ptr<GuardWatch> watching)
      : ChainingTransportDescriptor(std::move(below)), watch(std::move(watching)) {}

  rtps::TransportInterface* create_transport() const override {
    return new GuardedTransport(*this, watch);
  }

  const std::shared_ptr<GuardWatch> watch;
};

}  // namespace

std::optional<PacketFault> packetFault(Bytes datagram) {
  std::optional<PacketFault> fault;
  const bool whole = forEachSubmessage(datagram, [&](const Submessage& submessage, bool last) {
    if (fault) return;
    if (submessage.id == kStatisticsId && fromEprosima(datagram)) {
      if (!last) fault = PacketFault::kStatistics;
    } else {
      fault = faultOf(submessage);
    }
  });
  return fault || whole ? fault : PacketFault::kLength;
}

std::optional<PacketFault> PacketGuard::fault(Bytes datagram, Clock::time_point now) {
  if (const auto fault = packetFault(datagram)) return fault;
  const std::vector<SaidFirst> heartbeats = heartbeatsOf(datagram);
  if (heartbeats.empty()) return std::nullopt;
  const MutexLock lock(mutex_);
  for (const SaidFirst& said : heartbeats) {
    const auto found = writers_.find(said.writer);
    if (found == writers_.end()) continue;
    const Heard& heard = found->second;
    const std::chrono::duration<double> silent = now - heard.at;
    const double most = kLongestJump + kJumpPerSecond * silent.count();
    if (static_cast<double>(said.first - heard.first) > most) return PacketFault::kHeartbeat;
  }
  if (writers_.size() + heartbeats.size() > kMostWriters) writers_.clear();
  for (const SaidFirst& said : heartbeats) {
    Heard& heard = writers_[said.writer];
    heard = {std::max(heard.first, said.first), now};
  }
  return std::nullopt;
}

std::size_t PacketGuard::size() const {
  const MutexLock lock(mutex_);
  return writers_.size();
}

std::uint64_t GuardWatch::begin() {
  const MutexLock lock(mutex_);
  begun_.emplace(++numbers_, Clock::now());
  return numbers_;
}

void GuardWatch::end(std::uint64_t number) {
  const MutexLock lock(mutex_);
  begun_.erase(number);
}

GuardWatch::Clock::duration GuardWatch::atOne(Clock::time_point now) const {
  const MutexLock lock(mutex_);
  return begun_.empty() ? Clock::duration{} : now - begun_.begin()->second;
}

std::shared_ptr<rtps::TransportDescriptorInterface> guarded(
    std::shared_ptr<rtps::TransportDescriptorInterface> below, std::shared_ptr<GuardWatch> watch) {
  return std::make_shared<GuardedDescriptor>(std::move(below), std::move(watch));
}

}  // namespace handover::wire
