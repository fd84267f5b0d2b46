// SPDX-License-Identifier: Apache-2.0
// A daemon from start to stop, whatever does its planning.
#pragma once

#include "daemon_signals.hpp"
#include "runtime/plan_service.hpp"
#include "runtime/runtime.hpp"

#include <chrono>

namespace handover {

struct DaemonOptions {
  int domain = 0;
  RuntimeSettings runtime;  ///< id, version and callbacks are the daemon's own
  /// How long it tries to reach itself over the sockets, at the start and later on, before it gives
  /// up.
  std::chrono::milliseconds patience{15'000};
};

/// Joins the domain and serves until a stop signal; then every open request gets its outcome. At
/// SIGHUP cells are read again. False when the service could not prepare, which ends it too.
/// @throws wire::DdsError, also when nobody could reach it.
bool runDaemon(PlanService& service, const DaemonOptions& options, DaemonSignals& signals);

}  // namespace handover
