// SPDX-License-Identifier: Apache-2.0
#include "daemon.hpp"

#include "dds/dds_endpoint.hpp"
#include "dds/self_check.hpp"
#include "service_manager.hpp"
#include "wire/entities.hpp"

#include <handover/common/exit_code.hpp>
#include <handover/common/log.hpp>

#include <unistd.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace handover {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// For one round trip to come back, which takes milliseconds; a first one seconds at worst.
constexpr std::chrono::milliseconds kRoundTrip = 2s;

/// A new endpoint that its own probe can reach; null and why not.
std::unique_ptr<DdsEndpoint> tryToJoin(int domain, std::string& why_not) {
  try {
    auto endpoint = std::make_unique<DdsEndpoint>(DdsEndpointSettings{.domain = domain});
    if (endpoint->reachable(kRoundTrip)) return endpoint;
    why_not = "nothing comes back from the loopback interface";
  } catch (const wire::DdsError& error) {
    why_not = error.what();
  }
  return nullptr;
}

/// Joins the domain, however often that takes within `patience`. @throws wire::DdsError.
std::unique_ptr<DdsEndpoint> join(int domain, std::chrono::milliseconds patience) {
  const auto until = Clock::now() + patience;
  std::string why_not;
  while (true) {
    if (auto endpoint = tryToJoin(domain, why_not)) return endpoint;
    if (Clock::now() >= until) break;
    logger("handoverd")->warn("nobody can reach this daemon, trying again: {}", why_not);
    std::this_thread::sleep_for(500ms);
  }
  throw wire::DdsError("nobody can reach this daemon in domain " + std::to_string(domain) + ": " +
                       why_not + " (or the domain has more than 110 participants)");
}

}  // namespace

bool runDaemon(PlanService& service, const DaemonOptions& options, DaemonSignals& signals) {
  const auto log = logger("handoverd");
  wire::routeDdsLog(false);
  wire::deliverOverSockets();
  const auto endpoint = join(options.domain, options.patience);

  std::atomic<bool> prepare_failed = false, deaf = false;
  RuntimeSettings settings = options.runtime;
  settings.id = RequestId::random().bytes;
  settings.version = HANDOVER_VERSION;
  settings.on_prepare_failed = [&prepare_failed](const std::string&) {
    prepare_failed = true;
    DaemonSignals::setExitOfHang(kExitConfiguration);
    kill(getpid(), SIGTERM);  // main waits for a signal, this is one
  };
  Runtime runtime(service, *endpoint, settings);
  runtime.start();
  std::optional<SelfCheck> check(
      std::in_place,
      SelfCheck::Settings{.probe = [&endpoint] { return endpoint->reachable(kRoundTrip); },
                          .on_alive = [] { tellServiceManager("WATCHDOG=1"); },
                          .on_deaf =
                              [&deaf] {
                                deaf = true;
                                DaemonSignals::setExitOfHang(kExitDds);
                                kill(getpid(), SIGTERM);
                              },
                          .patience = options.patience});
  log->info("serving {} cells in domain {} with {} workers", service.served()->infos.size(),
            options.domain, settings.threads);
  tellServiceManager("READY=1");
  int signal = 0;
  while ((signal = signals.wait()) == SIGHUP) runtime.reload(signals.stopping());
  log->info("stopping: {}", strsignal(signal));
  tellServiceManager("STOPPING=1");
  check.reset();
  runtime.stop();
  if (deaf) throw wire::DdsError("nobody can reach this daemon any more");
  return !prepare_failed;
}

}  // namespace handover
