// SPDX-License-Identifier: Apache-2.0
// RTPS datagrams, byte by byte (little-endian), good and bad.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace handover::test {

using Bytes = std::vector<std::uint8_t>;
using EntityId = std::array<std::uint8_t, 4>;

/// The low `size` bytes of a number, the lowest first.
void append(Bytes& to, std::uint64_t value, int size);
void append(Bytes& to, const Bytes& more);

/// With its header; `flags` beside that of little-endian. `length`: what the header says, if not
/// the content's.
Bytes submessage(std::uint8_t id, const Bytes& content, std::uint8_t flags = 0, int length = -1);

/// From a participant of that prefix; of eProsima's, or of another vendor.
Bytes datagram(const std::vector<Bytes>& submessages, const std::array<std::uint8_t, 12>& from = {},
               std::array<std::uint8_t, 2> vendor = {1, 15});

/// To every reader of `writer`: samples first to base - 1 are not there.
Bytes gap(std::int64_t first, std::int64_t base, const EntityId& writer = {});

/// To every reader of `writer`: samples first to last are there.
Bytes heartbeat(std::int64_t first, std::int64_t last, std::uint32_t count = 1,
                const EntityId& writer = {});

/// As Fast DDS 2.9.1 ends its datagrams.
Bytes statistics();

/// Sample 1, its payload after `qos`; `to_qos` is the offset that it claims for that.
Bytes data(const Bytes& payload, const Bytes& qos = {}, std::uint16_t to_qos = 16);

/// Fragments of sample 1.
struct Fragment {
  std::uint32_t first = 1;
  std::uint16_t count = 1;
  std::uint16_t size = 100;
  std::uint32_t sample = 250;
  std::size_t payload = 100;
};

Bytes fragment(const Fragment& of);

/// What a participant says of itself to find others (RTPS 2.3, 8.5.3): the whole datagram.
struct Announcement {
  std::array<std::uint8_t, 12> from{};
  std::optional<std::array<std::uint8_t, 12>> announced = {};  ///< if not itself
  std::chrono::milliseconds lease{3000};
  bool with_lease = true, endless = false;
  std::uint32_t endpoints = 0x3f;  ///< built in, RTPS 2.3, 9.3.2
  std::int64_t sample = 1;
  int port = 7;  ///< of loopback, where it would hear
};

Bytes announcement(const Announcement& of);

/// That it leaves.
Bytes departure(const std::array<std::uint8_t, 12>& of);

}  // namespace handover::test
