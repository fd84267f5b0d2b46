// SPDX-License-Identifier: Apache-2.0
#include "rtps_packets.hpp"

namespace handover::test {
namespace {

/// The high half first.
void appendSequence(Bytes& to, std::int64_t number) {
  append(to, static_cast<std::uint64_t>(number) >> 32, 4);
  append(to, static_cast<std::uint64_t>(number) & 0xffffffff, 4);
}

/// To any reader, from `writer`.
Bytes betweenEntities(const EntityId& writer) {
  Bytes content;
  append(content, 0, 4);
  append(content, Bytes(writer.begin(), writer.end()));
  return content;
}

/// What data and its fragments begin with.
Bytes sampleOne(std::uint16_t to_qos) {
  Bytes content;
  append(content, 0, 2);
  append(content, to_qos, 2);
  append(content, betweenEntities({}));
  appendSequence(content, 1);
  return content;
}

}  // namespace

void append(Bytes& to, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) to.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

void append(Bytes& to, const Bytes& more) {
  for (const std::uint8_t byte : more) to.push_back(byte);
}

Bytes submessage(std::uint8_t id, const Bytes& content, std::uint8_t flags, int length) {
  Bytes bytes{id, static_cast<std::uint8_t>(flags | 1)};
  append(bytes, length < 0 ? content.size() : static_cast<std::uint64_t>(length), 2);
  append(bytes, content);
  return bytes;
}

Bytes datagram(const std::vector<Bytes>& submessages, const std::array<std::uint8_t, 12>& from,
               std::array<std::uint8_t, 2> vendor) {
  Bytes bytes{'R', 'T', 'P', 'S', 2, 3, vendor[0], vendor[1]};
  append(bytes, Bytes(from.begin(), from.end()));
  for (const Bytes& each : submessages) append(bytes, each);
  return bytes;
}

Bytes gap(std::int64_t first, std::int64_t base, const EntityId& writer) {
  Bytes content = betweenEntities(writer);
  appendSequence(content, first);
  appendSequence(content, base);
  append(content, 0, 4);
  return submessage(0x08, content);
}

Bytes heartbeat(std::int64_t first, std::int64_t last, std::uint32_t count,
                const EntityId& writer) {
  Bytes content = betweenEntities(writer);
  appendSequence(content, first);
  appendSequence(content, last);
  append(content, count, 4);
  return submessage(0x07, content);
}

Bytes statistics() { return submessage(0x80, Bytes(56)); }

Bytes data(const Bytes& payload, const Bytes& qos, std::uint16_t to_qos) {
  Bytes content = sampleOne(to_qos);
  append(content, qos);
  append(content, payload);
  return submessage(0x15, content, qos.empty() ? 4 : 6);
}

Bytes fragment(const Fragment& of) {
  Bytes content = sampleOne(28);
  append(content, of.first, 4);
  append(content, of.count, 2);
  append(content, of.size, 2);
  append(content, of.sample, 4);
  append(content, Bytes(of.payload));
  return submessage(0x16, content);
}

}  // namespace handover::test
