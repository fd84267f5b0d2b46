// SPDX-License-Identifier: Apache-2.0
#include "daemon.hpp"

#include "dds/dds_endpoint.hpp"
#include "service_manager.hpp"
#include "wire/entities.hpp"

#include <handover/common/log.hpp>

#include <unistd.h>

#include <atomic>
#include <cstring>

namespace handover {

bool runDaemon(PlanService& service, const DaemonOptions& options, DaemonSignals& signals) {
  const auto log = logger("handoverd");
  wire::routeDdsLog(false);
  DdsEndpoint endpoint({.domain = options.domain});

  std::atomic<bool> prepare_failed = false;
  RuntimeSettings settings = options.runtime;
  settings.id = RequestId::random().bytes;
  settings.version = HANDOVER_VERSION;
  settings.on_prepare_failed = [&prepare_failed](const std::string&) {
    prepare_failed = true;
    kill(getpid(), SIGTERM);  // main waits for a signal, this is one
  };
  settings.alive = [] { tellServiceManager("WATCHDOG=1"); };
  Runtime runtime(service, endpoint, settings);
  runtime.start();
  log->info("serving {} cells in domain {} with {} workers", service.served()->infos.size(),
            options.domain, settings.threads);
  tellServiceManager("READY=1");
  int signal = 0;
  while ((signal = signals.wait()) == SIGHUP) runtime.reload(signals.stopping());
  log->info("stopping: {}", strsignal(signal));
  tellServiceManager("STOPPING=1");
  runtime.stop();
  return !prepare_failed;
}

}  // namespace handover
