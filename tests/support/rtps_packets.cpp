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

void appendParameter(Bytes& to, std::uint64_t id, const Bytes& value) {
  append(to, id, 2);
  append(to, value.size(), 2);
  append(to, value);
}

Bytes participantGuid(const std::array<std::uint8_t, 12>& prefix) {
  Bytes guid(prefix.begin(), prefix.end());
  append(guid, Bytes{0, 0, 1, 0xc1});
  return guid;
}

Bytes loopback(int port) {
  Bytes locator;
  append(locator, 1, 4);
  append(locator, static_cast<std::uint64_t>(port), 4);
  append(locator, Bytes(12));
  append(locator, Bytes{127, 0, 0, 1});
  return locator;
}

/// Discovery's data, before what it carries.
Bytes toDiscovery(std::int64_t sample) {
  Bytes content;
  append(content, 16 << 16, 4);
  append(content, Bytes{0, 1, 0, 0xc7, 0, 1, 0, 0xc2});
  appendSequence(content, sample);
  return content;
}

Bytes duration(std::chrono::milliseconds lease) {
  const auto ms = static_cast<std::uint64_t>(lease.count());
  Bytes bytes;
  append(bytes, ms / 1000, 4);
  append(bytes, (ms % 1000 << 32) / 1000, 4);
  return bytes;
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

Bytes announcement(const Announcement& of) {
  Bytes content = toDiscovery(of.sample);
  append(content, Bytes{0, 3, 0, 0});
  appendParameter(content, 0x15, {2, 3, 0, 0});
  appendParameter(content, 0x16, {1, 15, 0, 0});
  appendParameter(content, 0x50, participantGuid(of.announced.value_or(of.from)));
  appendParameter(content, 0x32, loopback(of.port));
  appendParameter(content, 0x31, loopback(of.port));
  const Bytes endless{0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff};
  if (of.with_lease) appendParameter(content, 0x02, of.endless ? endless : duration(of.lease));
  Bytes endpoints;
  append(endpoints, of.endpoints, 4);
  appendParameter(content, 0x58, endpoints);
  appendParameter(content, 0x01, {});
  return datagram({submessage(0x15, content, 4)}, of.from);
}

Bytes departure(const std::array<std::uint8_t, 12>& of) {
  Bytes content = toDiscovery(2);
  appendParameter(content, 0x70, participantGuid(of));
  appendParameter(content, 0x71, {0, 0, 0, 3});
  appendParameter(content, 0x01, {});
  return datagram({submessage(0x15, content, 2)}, of);
}

}  // namespace handover::test
