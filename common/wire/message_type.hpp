// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fastcdr/exceptions/Exception.h>
#include <fastdds/rtps/common/SerializedPayload.h>

namespace handover::wire {

/// A generated type whose deserialize() refuses what it cannot read: the generated code lets
/// exceptions of Fast CDR through (a boolean that is neither 0 nor 1, an unknown encapsulation),
/// and one that leaves the receive thread ends the process.
template <typename Generated>
class MessageType : public Generated {
 public:
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      return Generated::deserialize(payload, data);
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
  }
};

}  // namespace handover::wire
