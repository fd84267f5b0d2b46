// SPDX-License-Identifier: Apache-2.0
// A daemon from start to stop, whatever does its planning.
#pragma once

#include "daemon_signals.hpp"
#include "runtime/plan_service.hpp"
#include "runtime/runtime.hpp"

namespace handover {

struct DaemonOptions {
  int domain = 0;
  RuntimeSettings runtime;  ///< id, version and callbacks are the daemon's own
};

/// Joins the domain and serves until a stop signal; then every open request gets its outcome. At
/// SIGHUP cells are read again. False when the service could not prepare, which ends it too.
/// @throws wire::DdsError.
bool runDaemon(PlanService& service, const DaemonOptions& options, DaemonSignals& signals);

}  // namespace handover
