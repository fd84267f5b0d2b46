// SPDX-License-Identifier: Apache-2.0
#include "wire/submessages.hpp"

#include <algorithm>
#include <string_view>

namespace handover::wire {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t kHeader = 20, kSubmessageHeader = 4, kPrefixAt = 8;

/// The submessage that begins a rest of a datagram; nullopt when it ends beyond it.
std::optional<Submessage> firstOf(Bytes rest, const GuidPrefix& from) {
  if (rest.size() < kSubmessageHeader) return std::nullopt;
  Submessage found{rest[0], rest[1], rest, false, from};
  const std::size_t length = found.shortAt(2);
  const Bytes after = rest.subspan(kSubmessageHeader);
  if (length > after.size()) return std::nullopt;
  // Without a length it is the last, to the end of the datagram; two kinds may be empty.
  found.last = length == 0 && found.id != kInfoTimestampId && found.id != kPadId;
  found.content = found.last ? after : after.first(length);
  return found;
}

GuidPrefix prefixAt(Bytes bytes) {
  GuidPrefix prefix{};
  std::copy_n(bytes.begin() + kPrefixAt, prefix.size(), prefix.begin());
  return prefix;
}

}  // namespace

std::array<std::uint8_t, 16> guidOf(const GuidPrefix& participant, Bytes entity) {
  std::array<std::uint8_t, 16> guid{};
  std::copy(participant.begin(), participant.end(), guid.begin());
  std::copy_n(entity.begin(), guid.size() - participant.size(), guid.begin() + participant.size());
  return guid;
}

std::uint32_t numberAt(Bytes bytes, std::size_t at, std::size_t size, bool little) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size && at + size <= bytes.size(); ++i) {
    value = value << 8 | bytes[little ? at + size - 1 - i : at + i];
  }
  return value;
}

std::uint16_t Submessage::shortAt(std::size_t at) const {
  return static_cast<std::uint16_t>(numberAt(content, at, 2, little()));
}

std::uint32_t Submessage::longAt(std::size_t at) const {
  return numberAt(content, at, 4, little());
}

std::int64_t Submessage::sequenceAt(std::size_t at) const {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(longAt(at)) << 32 | longAt(at + 4));
}

bool isRtps(Bytes datagram) {
  constexpr std::string_view kMagic = "RTPS";
  return datagram.size() >= kHeader && std::equal(kMagic.begin(), kMagic.end(), datagram.begin());
}

bool forEachSubmessage(Bytes datagram, const std::function<void(const Submessage&, bool)>& visit) {
  if (!isRtps(datagram)) return true;
  GuidPrefix from = prefixAt(datagram);
  Bytes rest = datagram.subspan(kHeader);
  while (!rest.empty()) {
    const auto submessage = firstOf(rest, from);
    if (!submessage) return false;
    // From there on somebody else speaks.
    if (submessage->id == kInfoSourceId && submessage->content.size() >= kHeader) {
      from = prefixAt(submessage->content);
    }
    // The next one begins at a multiple of four.
    const std::size_t padded = kSubmessageHeader + (submessage->content.size() + 3) / 4 * 4;
    rest = rest.subspan(std::min(padded, rest.size()));
    visit(*submessage, rest.empty());
  }
  return true;
}

std::optional<std::size_t> payloadOf(const Submessage& data, std::size_t members) {
  std::size_t at = 4 + static_cast<std::size_t>(data.shortAt(2));
  if (at < members || at > data.content.size()) return std::nullopt;
  if ((data.flags & kInlineQosFlag) == 0) return at;
  for (bool ended = false; !ended;) {
    if (at + 4 > data.content.size()) return std::nullopt;
    ended = data.shortAt(at) == kSentinelId;
    at += 4 + (ended ? 0 : static_cast<std::size_t>(data.shortAt(at + 2)));
  }
  return at <= data.content.size() ? std::optional(at) : std::nullopt;
}

}  // namespace handover::wire
