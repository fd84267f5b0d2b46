// SPDX-License-Identifier: Apache-2.0
// Wire types to values and back; the only place that knows both.
#pragma once

#include <handover/common/check.hpp>
#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <handover.h>

#include <variant>
#include <vector>

namespace handover::wire {

/// A value, or every fault of the message that it was to come from.
template <typename T>
using Decoded = std::variant<T, std::vector<Fault>>;

/// The messages of values that pass check(): see there for the bounds.
msg::HandoverRequest encode(const PlanRequest& request);
msg::PlanEvent encode(const PlanEvent& event);
msg::DaemonStatus encode(const DaemonStatus& status);
msg::Leader encode(const Claim& claim);
msg::HandoverCancel encodeCancel(const RequestId& id);

/// Checked values: another wire version, unknown enumerators and unions, and all that check()
/// refuses are faults. Unspecified mode and search stand for their defaults.
Decoded<PlanRequest> decode(const msg::HandoverRequest& message);
Decoded<PlanEvent> decode(const msg::PlanEvent& message);
Decoded<DaemonStatus> decode(const msg::DaemonStatus& message);
Decoded<Claim> decode(const msg::Leader& message);
Decoded<RequestId> decode(const msg::HandoverCancel& message);

}  // namespace handover::wire
