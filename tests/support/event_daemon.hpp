// SPDX-License-Identifier: Apache-2.0
// A daemon on the wire that answers a request with the events of a test.
#pragma once

#include "wire/codec.hpp"
#include "wire/entities.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace handover::test {

/// The status of a daemon that serves "script".
inline DaemonStatus scriptStatus() {
  DaemonStatus status;
  status.id = RequestId::random().bytes;
  status.version = "test";
  status.state = DaemonState::kReady;
  status.cells = {{"script", {"answer"}, 7, {}, ""}};
  return status;
}

/// Answers every request, of that client or of anybody.
class EventDaemon {
 public:
  EventDaemon(int domain, const std::string& client_id, std::vector<PlanEvent> events,
              bool announced = true)
      : events_(std::move(events)),
        participant_({.domain = domain, .name = "events", .on_writer = {}}),
        statuses_(participant_, {}),
        writer_(participant_, {.partition = client_id}),
        cancels_(participant_, {}, [](const auto&) {}),
        requests_(participant_, {}, [this](const wire::Sample<msg::HandoverRequest>& sample) {
          if (sample.message == nullptr) return;
          for (PlanEvent event : events_) {
            event.request_id = RequestId{sample.key};
            (void)writer_.write(wire::encode(event));
          }
        }) {
    if (announced) announce(scriptStatus());
  }

  void announce(const DaemonStatus& status) {
    EXPECT_EQ(statuses_.write(wire::encode(status)), wire::WriteResult::kOk);
  }

 private:
  const std::vector<PlanEvent> events_;
  wire::Participant participant_;
  wire::Writer<msg::DaemonStatus> statuses_;
  wire::Writer<msg::PlanEvent> writer_;
  wire::Reader<msg::HandoverCancel> cancels_;
  wire::Reader<msg::HandoverRequest> requests_;
};

}  // namespace handover::test
