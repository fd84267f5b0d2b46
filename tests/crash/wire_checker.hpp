// SPDX-License-Identifier: Apache-2.0
// The rules of an answer (one daemon's, of one scene, gapless, one outcome), held against what went
// over the wire and what arrived at clients.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/plan_event.hpp>

#include <condition_variable>
#include <mutex>
#include <string>
#include <vector>

namespace handover::test {

/// An event as it was heard.
struct HeardEvent {
  PlanEvent event;
  wire::Guid writer{};
};

/// What breaks the rules, a line each. An answer may end anywhere, with its daemon.
std::vector<std::string> wireFaults(const std::vector<HeardEvent>& heard);

/// Hears the events of all clients of a domain.
class WireRecorder {
 public:
  explicit WireRecorder(int domain);

  std::vector<HeardEvent> heard() const;

 private:
  mutable std::mutex mutex_;
  std::vector<HeardEvent> heard_;
  wire::Participant participant_;
  wire::Reader<msg::PlanEvent> reader_;
};

/// A client's exit code and the lines of its `--json`: what breaks the rules, empty for nothing.
/// Exit 0, 10, 11 and 12 need one outcome, after events from 0 on without a gap since the last
/// restart; 13 none since then.
std::string clientFault(int exit_code, const std::string& lines);

}  // namespace handover::test
