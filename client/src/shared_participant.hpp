// SPDX-License-Identifier: Apache-2.0
// One participant for all clients of a process and domain: each costs threads, ports and a place
// among the 110 that find each other.
#pragma once

#include "wire/entities.hpp"

#include <memory>

namespace handover::client {

/// The domain's participant, made if nobody has it. Safe from any thread. @throws wire::DdsError.
std::shared_ptr<const wire::Participant> sharedParticipant(int domain);

}  // namespace handover::client
