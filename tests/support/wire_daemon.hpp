// SPDX-License-Identifier: Apache-2.0
// The daemon's parts in the test's process, as their clients in others see them.
#pragma once

#include "dds/dds_endpoint.hpp"
#include "process.hpp"
#include "runtime/runtime.hpp"
#include "scripted_service.hpp"

#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <gtest/gtest.h>

#include <optional>

namespace handover::test {

/// As between processes: Fast DDS 2.9 hands samples over inside one process and loses some, also of
/// reliable writers, while another participant joins. Before the first participant.
inline void deliverOverSockets() {
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
}

/// A domain with, once started, a daemon of ScriptedService in it.
class WireDaemonTest : public testing::Test {
 public:
  static void SetUpTestSuite() { deliverOverSockets(); }

 protected:
  static PlanRequest scripted(const std::string& task) {
    return {.id = RequestId::random(), .client_id = "any", .cell = "script", .task = task};
  }

  void start(RuntimeSettings settings = {}) {
    settings.id = RequestId::random().bytes;
    settings.version = "test";
    endpoint.emplace(DdsEndpointSettings{.domain = domain});
    runtime.emplace(service, *endpoint, settings);
    runtime->start();
  }

  const int domain = freeDomain();
  ScriptedService service;
  std::optional<DdsEndpoint> endpoint;
  std::optional<Runtime> runtime;
};

}  // namespace handover::test
