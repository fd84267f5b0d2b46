// SPDX-License-Identifier: Apache-2.0
// A daemon whose planning does what the task's name says: for system tests of everything around
// planning. usage: scripted_daemon DOMAIN [PATIENCE_MS]
#include "daemon.hpp"
#include "scripted_service.hpp"
#include "wire/entities.hpp"

#include <handover/common/domain.hpp>
#include <handover/common/standard_streams.hpp>

#include <cstdlib>
#include <iostream>

int main(int argc, char** argv) {
  handover::holdStandardStreams();
  const auto domain = handover::parseDomain(argc >= 2 ? argv[1] : "");
  if (!domain) {
    std::cerr << "usage: scripted_daemon DOMAIN [PATIENCE_MS]\n";
    return 2;
  }
  handover::DaemonOptions options{.domain = *domain, .runtime = {}};
  if (argc > 2) options.patience = std::chrono::milliseconds(std::atoi(argv[2]));
  handover::DaemonSignals signals;
  handover::test::ScriptedService service;
  try {
    return handover::runDaemon(service, options, signals) ? 0 : 3;
  } catch (const handover::wire::DdsError& error) {
    std::cerr << error.what() << std::endl;
    return 4;
  }
}
