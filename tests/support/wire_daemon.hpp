// SPDX-License-Identifier: Apache-2.0
// The daemon's parts in the test's process, as their clients in others see them.
#pragma once

#include "dds/dds_endpoint.hpp"
#include "process.hpp"
#include "runtime/runtime.hpp"
#include "scripted_service.hpp"
#include "wire/entities.hpp"

#include <gtest/gtest.h>

#include <optional>

namespace handover::test {

/// A domain with, once started, a daemon of ScriptedService in it.
class WireDaemonTest : public testing::Test {
 public:
  /// As between processes. Fast DDS 2.9 hands samples over inside one process and loses some, also
  /// of reliable writers, while another participant joins.
  static void SetUpTestSuite() { wire::deliverOverSockets(); }

 protected:
  static PlanRequest scripted(const std::string& task) {
    return {.id = RequestId::random(), .client_id = "any", .cell = "script", .task = task};
  }

  void start(RuntimeSettings settings = {}, DdsEndpointSettings wire = {}) {
    settings.id = RequestId::random().bytes;
    settings.version = "test";
    wire.domain = domain;
    endpoint.emplace(wire);
    runtime.emplace(service, *endpoint, settings);
    runtime->start();
  }

  const int domain = freeDomain();
  ScriptedService service;
  std::optional<DdsEndpoint> endpoint;
  std::optional<Runtime> runtime;
};

}  // namespace handover::test
