// SPDX-License-Identifier: Apache-2.0
// What the client knows of a request on its way.
#pragma once

#include "wire/entities.hpp"

#include <handover/client/client.hpp>

#include <map>
#include <memory>
#include <optional>
#include <set>

namespace handover::client {

/// All below `future` is guarded by the client's mutex.
struct PlanHandle::State {
  using Clock = std::chrono::steady_clock;

  PlanRequest request;
  OnEvent on_event;
  OnRestart on_restart;
  std::weak_ptr<Client::Impl> client;
  std::promise<Outcome> promise;
  std::shared_future<Outcome> future = promise.get_future().share();

  std::shared_ptr<wire::Writer<msg::HandoverRequest>> writer;  ///< none before the write and after
  std::shared_ptr<wire::Writer<msg::HandoverCancel>> canceller;  ///< as long
  Clock::time_point written_at{}, heard_at{}, answered_at{};
  Clock::time_point asked_at{};                 ///< for the last time
  std::optional<AnswerId> answer;               ///< the one that is taken
  std::set<AnswerId> dropped;                   ///< those before it: their daemons may still write
  std::uint64_t epoch = 0;                      ///< of the leader whose answer is taken
  wire::Guid from{};                            ///< its events' writer
  std::set<AnswerId> outdated;                  ///< of leaders before it
  std::optional<Clock::time_point> planned_at;  ///< the first whole plan was there
  std::optional<Clock::time_point> failed_at;   ///< why there is none
  std::map<std::uint32_t, std::uint32_t> stages_missing;  ///< by solution
  std::uint32_t next_sequence = 0;
  bool ended = false;
  bool cell_was_served = false;
  bool cancel_wanted = false;
  Clock::time_point cancelled_at{};  ///< for the last time
  std::optional<Clock::time_point> lost_at;

  /// Forgets the answer so far; true when there was one.
  bool begin(const AnswerId& id);
  /// True when an event is of a leader that another one, whose answer is taken, has followed: it
  /// was stopped and goes on.
  bool isOutdated(const PlanEvent& event);
  /// Notes what the next event of the answer means for the request.
  void note(const PlanEvent& event, const wire::Guid& sender, Clock::time_point at);
};

}  // namespace handover::client
