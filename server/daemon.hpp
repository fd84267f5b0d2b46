// SPDX-License-Identifier: Apache-2.0
// A daemon from start to stop, whatever does its planning.
#pragma once

#include "runtime/plan_service.hpp"

#include <signal.h>

#include <chrono>
#include <functional>

namespace handover {

/// Blocks SIGINT and SIGTERM in the calling thread and all that it starts from then on.
class StopSignals {
 public:
  StopSignals();
  /// Waits for one of them.
  int wait() const;

 private:
  sigset_t set_;
};

struct DaemonOptions {
  int domain = 0;
  int threads = 1;
  /// How long it tries to reach itself over the sockets, at the start and later on, before it gives
  /// up.
  std::chrono::milliseconds patience{15'000};
  /// Called when it has just reached itself, every two seconds: feeds a watchdog.
  std::function<void()> alive = [] {};
};

/// Joins the domain and serves until a stop signal; then every open request gets its outcome. False
/// when the service could not prepare, which ends it too. @throws wire::DdsError, also when nobody
/// could reach it.
bool runDaemon(PlanService& service, const DaemonOptions& options, const StopSignals& signals);

}  // namespace handover
