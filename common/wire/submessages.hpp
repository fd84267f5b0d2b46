// SPDX-License-Identifier: Apache-2.0
// RTPS datagrams read as what they are made of (RTPS 2.3, 8.3 and 9.4), whatever they claim.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

namespace handover::wire {

enum SubmessageId : std::uint8_t {
  kPadId = 0x01,
  kHeartbeatId = 0x07,
  kGapId = 0x08,
  kInfoTimestampId = 0x09,
  kInfoSourceId = 0x0c,
  kHeartbeatFragId = 0x13,
  kDataId = 0x15,
  kDataFragId = 0x16,
  kStatisticsId = 0x80,
};

/// Of a data submessage.
enum DataFlag : std::uint8_t { kInlineQosFlag = 2, kWithDataFlag = 4 };

/// Ends a list of parameters.
constexpr std::uint16_t kSentinelId = 0x01;

using GuidPrefix = std::array<std::uint8_t, 12>;

/// Of an entity of a participant. @pre its id has four bytes.
std::array<std::uint8_t, 16> guidOf(const GuidPrefix& participant,
                                    std::span<const std::uint8_t> entity);

/// A number of up to four bytes. Reading beyond the end gives zeros: look at the size first.
std::uint32_t numberAt(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size,
                       bool little);

/// The content of a submessage, read in its byte order.
struct Submessage {
  std::uint8_t id = 0, flags = 0;
  std::span<const std::uint8_t> content;
  bool last = false;  ///< without a length: to the end of the datagram
  GuidPrefix from{};  ///< of the participant that speaks

  bool little() const { return (flags & 1) != 0; }

  std::uint16_t shortAt(std::size_t at) const;
  std::uint32_t longAt(std::size_t at) const;
  /// A sequence number: the high half signed, then the low one.
  std::int64_t sequenceAt(std::size_t at) const;
};

bool isRtps(std::span<const std::uint8_t> datagram);

/// Visits the submessages of an RTPS datagram, the last one with true, up to one that ends beyond
/// it: false then. What is not RTPS has none.
bool forEachSubmessage(std::span<const std::uint8_t> datagram,
                       const std::function<void(const Submessage&, bool)>& visit);

/// Where the payload of a data submessage begins, whose own members end at `members`; nullopt when
/// that is beyond the submessage.
std::optional<std::size_t> payloadOf(const Submessage& data, std::size_t members);

/// The members of a data submessage: extra flags, offset to inline QoS, reader, writer, sample.
constexpr std::size_t kDataMembers = 20;

}  // namespace handover::wire
