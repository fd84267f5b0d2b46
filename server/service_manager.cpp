// SPDX-License-Identifier: Apache-2.0
#include "service_manager.hpp"

#include <handover/common/unix_datagram.hpp>

#include <cstdlib>

namespace handover {

void tellServiceManager(std::string_view state) {
  if (const char* socket = std::getenv("NOTIFY_SOCKET")) sendUnixDatagram(socket, state);
}

}  // namespace handover
