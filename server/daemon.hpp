// SPDX-License-Identifier: Apache-2.0
// A daemon from start to stop, whatever does its planning.
#pragma once

#include "runtime/plan_service.hpp"

#include <signal.h>

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
};

/// Joins the domain and serves until a stop signal; then every open request gets its outcome. False
/// when the service could not prepare, which ends it too. @throws wire::DdsError.
bool runDaemon(PlanService& service, const DaemonOptions& options, const StopSignals& signals);

}  // namespace handover
