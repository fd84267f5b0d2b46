// SPDX-License-Identifier: Apache-2.0
// Messages of every topic: the first byte says which, the rest is what came from the wire.
#include "support/sample_events.hpp"
#include "target.hpp"
#include "wire/codec.hpp"
#include "wire/message_type.hpp"

#include <fastdds/rtps/common/SerializedPayload.h>
#include <handoverPubSubTypes.h>

#include <algorithm>
#include <stdexcept>

namespace handover::fuzz {
namespace {

using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

template <typename Type, typename Message>
std::string bytesOf(char topic, Message message) {
  Type type;
  Payload payload(type.getSerializedSizeProvider(&message)());
  type.serialize(&message, &payload);
  return std::string(1, topic) +
         std::string(reinterpret_cast<const char*>(payload.data), payload.length);
}

/// False: it is no message at all.
template <typename Type, typename Message>
bool read(std::string_view bytes, Message& message) {
  wire::MessageType<Type> type;
  Payload payload(static_cast<std::uint32_t>(std::max<std::size_t>(bytes.size(), 4)));
  std::copy(bytes.begin(), bytes.end(), payload.data);
  payload.length = static_cast<std::uint32_t>(bytes.size());
  return bytes.size() >= 4 && type.deserialize(&payload, &message);
}

/// What is taken is said again in the same words.
template <typename Type, typename Message>
void runTopic(std::string_view bytes) {
  Message message;
  if (!read<Type>(bytes, message)) return;
  const auto decoded = wire::decode(message);
  if (decoded.index() != 0) return;
  const auto again = [&] {
    if constexpr (std::is_same_v<Message, msg::HandoverCancel>) {
      return wire::decode(wire::encodeCancel(std::get<0>(decoded)));
    } else {
      return wire::decode(wire::encode(std::get<0>(decoded)));
    }
  }();
  if (again != decoded) throw std::logic_error("a message is not itself after encoding");
}

PlanRequest sampleRequest() {
  PlanRequest request;
  request.id = RequestId::fromHex("00112233445566778899aabbccddeeff").value();
  request.client_id = "fuzz";
  request.cell = "butler";
  request.chain = {"crichton/right", "hubo"};
  request.overrides = {{"robots.hubo.base.xyz", "[1, 2, 3]"}};
  request.deadline_s = 2.5;
  return request;
}

DaemonStatus sampleStatus() {
  DaemonStatus status;
  status.id = {7};
  status.version = "1.2.3";
  status.state = DaemonState::kReady;
  CellInfo cell{"butler", {"serve"}, 3, {}, "0123abcd"};
  cell.variations = {{"number", {0}, {1}, {}, {}}, {"word", {}, {}, {}, {"low", "high"}}};
  status.cells = {cell};
  return status;
}

}  // namespace

std::vector<std::string> seeds() {
  const PlanRequest request = sampleRequest();
  std::vector<std::string> all{
      bytesOf<msg::HandoverRequestPubSubType>(0, wire::encode(request)),
      bytesOf<msg::HandoverCancelPubSubType>(1, wire::encodeCancel(request.id)),
      bytesOf<msg::DaemonStatusPubSubType>(2, wire::encode(sampleStatus()))};
  for (const PlanEvent& event : test::sampleEvents(request.id, test::samplePayloads())) {
    all.push_back(bytesOf<msg::PlanEventPubSubType>(3, wire::encode(event)));
  }
  return all;
}

void run(std::string_view input) {
  if (input.empty()) return;
  const char topic = input.front();
  input.remove_prefix(1);
  if (topic == 0) runTopic<msg::HandoverRequestPubSubType, msg::HandoverRequest>(input);
  if (topic == 1) runTopic<msg::HandoverCancelPubSubType, msg::HandoverCancel>(input);
  if (topic == 2) runTopic<msg::DaemonStatusPubSubType, msg::DaemonStatus>(input);
  if (topic == 3) runTopic<msg::PlanEventPubSubType, msg::PlanEvent>(input);
}

}  // namespace handover::fuzz
