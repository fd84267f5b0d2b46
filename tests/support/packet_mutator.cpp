// SPDX-License-Identifier: Apache-2.0
#include "packet_mutator.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace handover::test {
namespace {

constexpr std::size_t kHeader = 20, kSubmessageHeader = 4;

enum Kind : std::uint8_t {
  kPad = 0x01,
  kAckNack = 0x06,
  kHeartbeat = 0x07,
  kGap = 0x08,
  kInfoTimestamp = 0x09,
  kInfoSource = 0x0c,
  kInfoReplyIp4 = 0x0d,
  kInfoDestination = 0x0e,
  kInfoReply = 0x0f,
  kNackFragment = 0x12,
  kHeartbeatFragment = 0x13,
  kData = 0x15,
  kDataFragment = 0x16,
  kSecureBody = 0x30,
  kSecurePrefix = 0x31,
  kStatistics = 0x80,
};

constexpr std::array<std::uint8_t, 16> kKinds{
    kPad,          kAckNack,         kHeartbeat,    kGap,          kInfoTimestamp,     kInfoSource,
    kInfoReplyIp4, kInfoDestination, kInfoReply,    kNackFragment, kHeartbeatFragment, kData,
    kDataFragment, kSecureBody,      kSecurePrefix, kStatistics};

void write(Bytes& to, std::size_t at, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i)
    to[at + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value >> 8 * i);
}

std::uint64_t read(const Bytes& from, std::size_t at, int size) {
  std::uint64_t value = 0;
  for (int i = size; i-- > 0;) value = value << 8 | from[at + static_cast<std::size_t>(i)];
  return value;
}

/// The high half first.
void appendSequence(Bytes& to, std::uint64_t number) {
  append(to, number >> 32, 4);
  append(to, number & 0xffffffff, 4);
}

bool hasCount(const TakenApart::Part& part) {
  return (part.id == kHeartbeat || part.id == kAckNack) && part.content.size() >= 28;
}

/// Reader and writer are the first members, but of data, where they come after the flags.
std::size_t entitiesAt(std::uint8_t id) { return id == kData || id == kDataFragment ? 4 : 0; }

bool namesEntities(const TakenApart::Part& part) {
  static constexpr std::array kNaming{kAckNack,      kHeartbeat,        kGap, kData, kDataFragment,
                                      kNackFragment, kHeartbeatFragment};
  const bool names = std::find(kNaming.begin(), kNaming.end(), part.id) != kNaming.end();
  return names && part.content.size() >= entitiesAt(part.id) + 8;
}

}  // namespace

TakenApart takeApart(const Bytes& datagram) {
  TakenApart apart;
  const auto at = [&](std::size_t index) {
    return datagram.begin() + static_cast<std::ptrdiff_t>(index);
  };
  apart.header.assign(datagram.begin(), at(std::min(kHeader, datagram.size())));
  for (std::size_t i = kHeader; i + kSubmessageHeader <= datagram.size();) {
    const std::size_t from = i + kSubmessageHeader, rest = datagram.size() - from;
    const std::size_t said = (datagram[i + 1] & 1) != 0
                                 ? static_cast<std::size_t>(datagram[i + 2] | datagram[i + 3] << 8)
                                 : static_cast<std::size_t>(datagram[i + 3] | datagram[i + 2] << 8);
    const bool to_the_end = said == 0 && datagram[i] != kPad && datagram[i] != kInfoTimestamp;
    const std::size_t length = to_the_end ? rest : std::min(said, rest);
    apart.parts.push_back({datagram[i], datagram[i + 1], {at(from), at(from + length)}});
    i = from + length;
  }
  return apart;
}

Bytes join(const TakenApart& apart) {
  Bytes bytes = apart.header;
  for (const auto& part : apart.parts) {
    const std::size_t length =
        part.length < 0 ? part.content.size() : static_cast<std::size_t>(part.length);
    const bool little = (part.flags & 1) != 0;
    bytes.push_back(part.id);
    bytes.push_back(part.flags);
    bytes.push_back(static_cast<std::uint8_t>(little ? length : length >> 8));
    bytes.push_back(static_cast<std::uint8_t>(little ? length >> 8 : length));
    append(bytes, part.content);
  }
  return bytes;
}

std::vector<std::uint8_t> kindsOf(const Bytes& datagram) {
  std::vector<std::uint8_t> kinds;
  for (const auto& part : takeApart(datagram).parts) kinds.push_back(part.id);
  return kinds;
}

Bytes PacketMutator::mutant(const Bytes& of, std::span<const Bytes> others) {
  TakenApart datagram = takeApart(of);
  // Repeated counts are passed over, and all that is in them.
  for (auto& part : datagram.parts) {
    if (below(2) == 0) raiseCount(part);
  }
  const std::uint32_t changes = 1 + below(4);
  for (std::uint32_t i = 0; i < changes && !datagram.parts.empty(); ++i) {
    change(datagram, others[below(others.size())]);
  }
  Bytes bytes = join(datagram);
  if (below(4) == 0) changeBytes(bytes);
  constexpr std::size_t kLargestDatagram = 65'000;
  if (bytes.size() > kLargestDatagram) bytes.resize(kLargestDatagram);
  return bytes;
}

std::uint64_t PacketMutator::edge(int size) {
  const std::uint64_t top = std::uint64_t{1} << (8 * size - 1);
  const std::array edges{std::uint64_t{0},
                         std::uint64_t{1},
                         top - 1,
                         top,
                         ~std::uint64_t{0},
                         std::uint64_t{below(300)},
                         std::uint64_t{1} << below(static_cast<std::size_t>(8 * size)),
                         random_.bits()};
  return edges[below(edges.size())];
}

void PacketMutator::change(TakenApart& datagram, const Bytes& other) {
  auto& parts = datagram.parts;
  switch (below(10)) {
    case 0: {
      const TakenApart::Part twice = anyPart(datagram);
      parts.insert(parts.begin() + below(parts.size() + 1), twice);
      return;
    }
    case 1:
      return std::swap(anyPart(datagram), anyPart(datagram));
    case 2: {
      const auto edges = std::array{0u, 1u, 3u, 0xffffu, below(1 << 16)};
      auto& part = anyPart(datagram);
      part.length = static_cast<int>(below(2) == 0 ? edges[below(edges.size())]
                                                   : part.content.size() + below(9));
      return;
    }
    case 3:
      anyPart(datagram).id = kKinds[below(kKinds.size())];
      return;
    case 4:
      anyPart(datagram).flags ^= static_cast<std::uint8_t>(1u << below(8));
      return;
    case 5: {
      const TakenApart from = takeApart(other);
      if (!from.parts.empty()) parts.push_back(from.parts[below(from.parts.size())]);
      return;
    }
    case 6: {
      Bytes& content = anyPart(datagram).content;
      content.resize(below(2) == 0 ? below(content.size() + 1) : content.size() + below(64));
      return;
    }
    case 7:
      return insertMade(datagram);
    default:
      return setField(anyPart(datagram).content);
  }
}

void PacketMutator::setField(Bytes& content) {
  const int size = 1 << below(4);
  if (content.size() < static_cast<std::size_t>(size)) return;
  const std::size_t at =
      below(content.size() / static_cast<std::size_t>(size)) * static_cast<std::size_t>(size);
  if (size == 8 && below(2) == 0) {  // a sequence number, near to what it was
    return write(content, at + 4, read(content, at + 4, 4) + below(64) - 32, 4);
  }
  write(content, at, edge(size), size);
}

void PacketMutator::raiseCount(TakenApart::Part& part) {
  if (!hasCount(part) || (part.flags & 1) == 0) return;
  const std::size_t at = part.content.size() - 4;
  write(part.content, at, read(part.content, at, 4) + 1 + below(1000), 4);
}

void PacketMutator::insertMade(TakenApart& datagram) {
  const auto known = std::find_if(datagram.parts.begin(), datagram.parts.end(), namesEntities);
  if (known == datagram.parts.end()) return;
  const auto place = datagram.parts.begin() + below(2) + (known - datagram.parts.begin());
  datagram.parts.insert(place, madeAbout(*known));
}

/// A submessage about the same reader and writer, its numbers at edges.
TakenApart::Part PacketMutator::madeAbout(const TakenApart::Part& known) {
  static constexpr std::array kMade{kGap,          kHeartbeat,         kAckNack,
                                    kNackFragment, kHeartbeatFragment, kDataFragment};
  TakenApart::Part made{kMade[below(kMade.size())], 1, {}};
  if (made.id == kDataFragment) append(made.content, 28u << 16, 4);
  const auto entities = known.content.begin() + static_cast<std::ptrdiff_t>(entitiesAt(known.id));
  made.content.insert(made.content.end(), entities, entities + 8);
  const std::uint32_t numbers = 1 + below(3);
  for (std::uint32_t i = 0; i < numbers; ++i) {
    appendSequence(made.content, below(2) == 0 ? below(100) : edge(8));
  }
  const std::uint32_t words = below(12);  // bits of sets, counts, fragments
  for (std::uint32_t i = 0; i < words; ++i)
    append(made.content, below(2) == 0 ? below(256) : edge(4), 4);
  return made;
}

void PacketMutator::changeBytes(Bytes& datagram) {
  if (below(4) == 0) return datagram.resize(below(datagram.size() + 1));
  const std::uint32_t flips = 1 + below(8);
  for (std::uint32_t i = 0; i < flips && !datagram.empty(); ++i) {
    datagram[below(datagram.size())] ^= static_cast<std::uint8_t>(1u << below(8));
  }
}

}  // namespace handover::test
