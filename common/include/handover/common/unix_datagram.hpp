// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace handover {

/// Sends one datagram to a socket of this machine, without waiting for whoever reads there.
/// @param socket  a path, or @NAME in the abstract space. @return false: it was not taken.
bool sendUnixDatagram(const std::string& socket, std::string_view bytes);

}  // namespace handover
