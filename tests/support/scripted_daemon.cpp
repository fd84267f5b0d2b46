// SPDX-License-Identifier: Apache-2.0
// A daemon whose planning does what the task's name says: for system tests of everything around
// planning. usage: scripted_daemon DOMAIN
#include "daemon.hpp"
#include "scripted_service.hpp"

#include <handover/common/domain.hpp>
#include <handover/common/standard_streams.hpp>

#include <iostream>

int main(int argc, char** argv) {
  handover::holdStandardStreams();
  const auto domain = handover::parseDomain(argc == 2 ? argv[1] : "");
  if (!domain) {
    std::cerr << "usage: scripted_daemon DOMAIN\n";
    return 2;
  }
  handover::DaemonSignals signals;
  handover::test::ScriptedService service;
  return handover::runDaemon(service, {.domain = *domain}, signals) ? 0 : 3;
}
