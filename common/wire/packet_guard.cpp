// SPDX-License-Identifier: Apache-2.0
#include "wire/packet_guard.hpp"

#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace handover::wire {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kHeader = 20, kSubmessageHeader = 4;  // RTPS 2.3, 8.3.3

enum SubmessageId : std::uint8_t {
  kGapId = 0x08,
  kHeartbeatId = 0x07,
  kInfoTimestampId = 0x09,
  kInfoSourceId = 0x0c,
  kPadId = 0x01,
  kHeartbeatFragId = 0x13,
  kDataId = 0x15,
  kDataFragId = 0x16,
  kStatisticsId = 0x80,
};

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

/// The content of a submessage, read in its byte order. Reading beyond the end gives zeros: look at
/// the size first.
struct Submessage {
  std::uint8_t id = 0, flags = 0;
  Bytes content;
  bool last = false;

  bool little() const { return (flags & 1) != 0; }

  std::uint32_t number(std::size_t at, std::size_t size) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size && at + size <= content.size(); ++i) {
      value = value << 8 | content[little() ? at + size - 1 - i : at + i];
    }
    return value;
  }

  std::uint16_t shortAt(std::size_t at) const { return static_cast<std::uint16_t>(number(at, 2)); }

  std::uint32_t longAt(std::size_t at) const { return number(at, 4); }

  /// A sequence number: the high half signed, then the low one.
  std::int64_t sequenceAt(std::size_t at) const {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(longAt(at)) << 32 | longAt(at + 4));
  }
};

/// The submessage that begins a rest of a datagram; nullopt when it ends beyond it.
std::optional<Submessage> firstOf(Bytes rest) {
  if (rest.size() < kSubmessageHeader) return std::nullopt;
  Submessage found{rest[0], rest[1], rest, false};
  const std::size_t length = found.shortAt(2);
  const Bytes after = rest.subspan(kSubmessageHeader);
  if (length > after.size()) return std::nullopt;
  // Without a length it is the last, to the end of the datagram; two kinds may be empty.
  found.last = length == 0 && found.id != kInfoTimestampId && found.id != kPadId;
  found.content = found.last ? after : after.first(length);
  return found;
}

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

/// Where the payload of a data submessage begins, whose own members end at `members`; nullopt when
/// that is beyond the submessage.
std::optional<std::size_t> payloadOf(const Submessage& data, std::size_t members) {
  constexpr std::uint8_t kInlineQos = 2;
  constexpr std::uint16_t kSentinel = 1;
  std::size_t at = 4 + static_cast<std::size_t>(data.shortAt(2));
  if (at < members || at > data.content.size()) return std::nullopt;
  if ((data.flags & kInlineQos) == 0) return at;
  for (bool ended = false; !ended;) {
    if (at + 4 > data.content.size()) return std::nullopt;
    ended = data.shortAt(at) == kSentinel;
    at += 4 + (ended ? 0 : static_cast<std::size_t>(data.shortAt(at + 2)));
  }
  return at <= data.content.size() ? std::optional(at) : std::nullopt;
}

std::optional<PacketFault> dataFault(const Submessage& data) {
  if (data.content.size() < 20) return PacketFault::kLength;
  if (numberedTooFar(data)) return PacketFault::kSequence;
  return payloadOf(data, 20) ? std::nullopt : std::optional(PacketFault::kData);
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

bool isRtps(Bytes datagram) {
  constexpr std::string_view kMagic = "RTPS";
  return datagram.size() >= kHeader && std::equal(kMagic.begin(), kMagic.end(), datagram.begin());
}

/// Visits the submessages of an RTPS datagram, up to one that ends beyond it: false then.
template <typename Visit>
bool forEachSubmessage(Bytes datagram, Visit visit) {
  if (!isRtps(datagram)) return true;
  Bytes rest = datagram.subspan(kHeader);
  while (!rest.empty()) {
    const auto submessage = firstOf(rest);
    if (!submessage) return false;
    // The next one begins at a multiple of four.
    const std::size_t padded = kSubmessageHeader + (submessage->content.size() + 3) / 4 * 4;
    rest = rest.subspan(std::min(padded, rest.size()));
    visit(*submessage, rest.empty());
  }
  return true;
}

/// What a heartbeat says is its writer's first sample.
struct SaidFirst {
  std::array<std::uint8_t, 16> writer{};
  std::int64_t first = 0;
};

/// @pre `datagram` has no fault.
std::vector<SaidFirst> heartbeatsOf(Bytes datagram) {
  constexpr std::size_t kPrefix = 12, kPrefixAt = 8;
  std::vector<SaidFirst> found;
  SaidFirst next;
  if (isRtps(datagram)) std::copy_n(datagram.begin() + kPrefixAt, kPrefix, next.writer.begin());
  forEachSubmessage(datagram, [&](const Submessage& submessage, bool) {
    const Bytes content = submessage.content;
    // From here on somebody else speaks.
    if (submessage.id == kInfoSourceId && content.size() >= kPrefixAt + kPrefix) {
      std::copy_n(content.begin() + kPrefixAt, kPrefix, next.writer.begin());
    }
    if (submessage.id != kHeartbeatId) return;
    std::copy_n(content.begin() + 4, 4, next.writer.begin() + kPrefix);
    next.first = submessage.sequenceAt(8);
    found.push_back(next);
  });
  return found;
}

bool fromEprosima(Bytes datagram) { return datagram[6] == 0x01 && datagram[7] == 0x0f; }

class GuardedTransport final : public rtps::ChainingTransport {
 public:
  GuardedTransport(const rtps::ChainingTransportDescriptor& descriptor,
                   std::shared_ptr<DropCounter> dropped)
      : ChainingTransport(descriptor), dropped_(std::move(dropped)) {}

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
    if (guard_.fault({data, size})) {
      ++*dropped_;
    } else {
      next->OnDataReceived(data, size, local, remote);
    }
  }

 private:
  PacketGuard guard_;
  const std::shared_ptr<DropCounter> dropped_;
};

struct GuardedDescriptor final : public rtps::ChainingTransportDescriptor {
  GuardedDescriptor(std::shared_ptr<rtps::TransportDescriptorInterface> below,
                    std::shared_ptr<DropCounter> counter)
      : ChainingTransportDescriptor(std::move(below)), dropped(std::move(counter)) {}

  rtps::TransportInterface* create_transport() const override {
    return new GuardedTransport(*this, dropped);
  }

  const std::shared_ptr<DropCounter> dropped;
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

std::shared_ptr<rtps::TransportDescriptorInterface> guarded(
    std::shared_ptr<rtps::TransportDescriptorInterface> below,
    std::shared_ptr<DropCounter> dropped) {
  return std::make_shared<GuardedDescriptor>(std::move(below), std::move(dropped));
}

}  // namespace handover::wire
