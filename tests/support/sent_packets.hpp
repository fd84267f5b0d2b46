// SPDX-License-Identifier: Apache-2.0
// What this process sends over UDP, recorded. A program that links it has the C library's sending
// functions replaced by ones that look on and pass on, in the middleware too.
#pragma once

#include "rtps_packets.hpp"

#include <cstddef>
#include <vector>

namespace handover::test {

struct SentPacket {
  int port = 0;  ///< it went to
  Bytes bytes;
};

/// The last RTPS datagrams sent by all threads, oldest first. Safe from any thread.
std::vector<SentPacket> sentPackets();
void forgetSentPackets();

/// While it lives, what its thread sends is not recorded.
class Unrecorded {
 public:
  Unrecorded();
  ~Unrecorded();
  Unrecorded(const Unrecorded&) = delete;
  Unrecorded& operator=(const Unrecorded&) = delete;
};

}  // namespace handover::test
