// SPDX-License-Identifier: Apache-2.0
#include "wire/codec.hpp"
#include "wire/entities.hpp"
#include "wire/known_daemons.hpp"

#include <handover/client/client.hpp>
#include <handover/common/check.hpp>
#include <handover/common/domain.hpp>
#include <handover/common/mutex.hpp>

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <thread>

namespace handover::client {
namespace {

using Clock = std::chrono::steady_clock;
using Code = ClientError::Code;

/// A little more than the period at which participants announce themselves.
constexpr std::chrono::milliseconds kAnnouncements{300};

int domainOf(const ClientOptions& options) {
  if (options.domain) return *options.domain;
  const std::string text = environmentDomain().value_or("0");
  if (const auto domain = parseDomain(text)) return *domain;
  throw std::invalid_argument("HANDOVER_DOMAIN '" + text + "' is not a number from 0 to " +
                              std::to_string(kMaxDomain));
}

std::string randomClientId() { return "client-" + RequestId::random().hex().substr(0, 12); }

}  // namespace

struct PlanHandle::State {
  PlanRequest request;
  OnEvent on_event;
  OnRestart on_restart;
  std::weak_ptr<Client::Impl> client;
  std::promise<Outcome> promise;
  std::shared_future<Outcome> future = promise.get_future().share();

  // Guarded by the client's mutex.
  Clock::time_point written_at{}, answered_at{};
  std::optional<AnswerId> answer;               ///< the one that is taken
  std::set<AnswerId> dropped;                   ///< those before it: their daemons may still write
  std::optional<Clock::time_point> planned_at;  ///< the first whole plan was there
  std::optional<Clock::time_point> failed_at;   ///< why there is none
  std::map<std::uint32_t, std::uint32_t> stages_missing;  ///< by solution
  std::uint32_t next_sequence = 0;
  bool ended = false;
  bool cell_was_served = false;
  bool cancel_wanted = false;
  std::optional<Clock::time_point> lost_at;

  /// Forgets the answer so far; true when there was one. With the client's mutex held.
  bool begin(const AnswerId& id) {
    const bool again = answer.has_value();
    if (again) dropped.insert(*answer);
    answer = id;
    planned_at.reset();
    failed_at.reset();
    stages_missing.clear();
    next_sequence = 0;
    return again;
  }

  /// Notes what an event means for the request. With the client's mutex held.
  void note(const PlanEvent& event, Clock::time_point at) {
    ++next_sequence;
    if (const auto* solution = std::get_if<Solution>(&event.payload)) {
      stages_missing[solution->index] = solution->stage_count;
    } else if (const auto* stage = std::get_if<StageTrajectory>(&event.payload)) {
      const auto found = stages_missing.find(stage->solution);
      const bool whole = found != stages_missing.end() && --found->second == 0;
      if (whole && !planned_at) planned_at = at;
    } else if (std::holds_alternative<Failure>(event.payload) && !failed_at) {
      failed_at = at;
    } else if (const auto* outcome = std::get_if<Outcome>(&event.payload)) {
      if (std::holds_alternative<Failed>(*outcome) && !failed_at) failed_at = at;
      if (!std::holds_alternative<Failed>(*outcome)) failed_at.reset();
    }
  }
};

struct Client::Impl {
  using Pending = std::shared_ptr<PlanHandle::State>;

  struct Arrival {
    Clock::time_point at;
    RequestId id;
    wire::Decoded<PlanEvent> event;
    bool watched = false;
  };

  const ClientOptions options;
  const int domain;
  const std::string client_id;

  Mutex mutex;
  Condition changed;
  wire::KnownDaemons known_daemons HANDOVER_GUARDED_BY(mutex);
  std::map<RequestId, Pending> pending HANDOVER_GUARDED_BY(mutex);
  std::deque<Arrival> arrivals HANDOVER_GUARDED_BY(mutex);
  OnEvent on_watched HANDOVER_GUARDED_BY(mutex);
  bool interrupted HANDOVER_GUARDED_BY(mutex) = false;
  bool stopping HANDOVER_GUARDED_BY(mutex) = false;

  // Last but the thread: their callbacks use all above.
  wire::Participant participant;
  wire::Writer<msg::HandoverRequest> requests;
  wire::Writer<msg::HandoverCancel> cancels;
  wire::Reader<msg::PlanEvent> events;
  wire::Reader<msg::DaemonStatus> statuses;
  std::optional<wire::Reader<msg::PlanEvent>> watched;

  std::jthread dispatcher;

  explicit Impl(const ClientOptions& given)
      : options(given),
        domain(domainOf(given)),
        client_id(given.client_id.empty() ? randomClientId() : given.client_id),
        participant({.domain = domain, .name = "handover client", .on_writer = {}}),
        requests(participant,
                 {.user_data = client_id, .on_match = [this](const auto&) { touch(); }}),
        cancels(participant, {.on_match = [this](const auto&) { touch(); }}),
        events(participant, {.partition = client_id, .on_match = [this](const auto&) { touch(); }},
               [this](const auto& sample) { onEvent(sample, false); }),
        statuses(participant, {.on_match = [this](const auto& match) { onStatusMatch(match); }},
                 [this](const auto& sample) { onStatus(sample); }),
        dispatcher([this] { dispatch(); }) {}

  /// Ends the thread; requests still open fail.
  void shutDown() {
    {
      const MutexLock lock(mutex);
      stopping = true;
    }
    changed.notify_all();
    dispatcher.join();
    const MutexLock lock(mutex);
    for (const auto& [id, state] : pending) {
      state->promise.set_exception(
          std::make_exception_ptr(ClientError(Code::kInterrupted, "the client was closed")));
    }
  }

  // ---- DDS threads: note and wake ----

  void touch() {
    const MutexLock lock(mutex);
    changed.notify_all();
  }

  void onEvent(const wire::Sample<msg::PlanEvent>& sample, bool by_watch) {
    if (sample.message == nullptr) return;
    Arrival arrival{Clock::now(), RequestId{sample.key}, wire::decode(*sample.message), by_watch};
    const MutexLock lock(mutex);
    arrivals.push_back(std::move(arrival));
    changed.notify_all();
  }

  void onStatus(const wire::Sample<msg::DaemonStatus>& sample) {
    const MutexLock lock(mutex);
    known_daemons.take(sample);
    changed.notify_all();
  }

  void onStatusMatch(const wire::Match& match) {
    if (match.gained) return;
    const MutexLock lock(mutex);
    known_daemons.lose(match.peer);
    changed.notify_all();
  }

  // ---- callers' threads ----

  /// Waits for a condition, at most until `until`; false when it was not met. @throws kInterrupted.
  template <typename Test>
  bool await(MutexLock& lock, Clock::time_point until, Test test) HANDOVER_REQUIRES(mutex) {
    const bool met = changed.wait_until(
        lock, until, [&]() HANDOVER_REQUIRES(mutex) { return interrupted || test(); });
    if (interrupted) throw ClientError(Code::kInterrupted, "interrupted");
    return met && test();
  }

  /// Matched both ways: what is written from now on arrives, and so does the answer.
  void awaitDaemon(MutexLock& lock) HANDOVER_REQUIRES(mutex) {
    const auto until = Clock::now() + options.wait;
    const bool there = await(lock, until, [this]() HANDOVER_REQUIRES(mutex) {
      return !known_daemons.empty() && requests.matched() > 0 && cancels.matched() > 0;
    });
    if (!there) {
      throw ClientError(Code::kNoDaemon, "no daemon in domain " + std::to_string(domain));
    }
    // The daemon makes our events writer as soon as it sees our request writer. One that does not
    // know us makes it with the first request; its events wait for us then.
    using namespace std::chrono_literals;
    await(lock, std::min(until, Clock::now() + 500ms), [this] { return events.matched() > 0; });
  }

  /// Waits for a daemon beyond those known, at most a period of announcements.
  void awaitMore(MutexLock& lock, std::size_t known) HANDOVER_REQUIRES(mutex) {
    await(lock, Clock::now() + kAnnouncements,
          [this, known]() HANDOVER_REQUIRES(mutex) { return known_daemons.size() > known; });
  }

  void sendCancel(const RequestId& id) {
    // Ours end with the instance too, but the message is what other clients can send.
    if (cancels.write(wire::encodeCancel(id)) != wire::WriteResult::kOk) {
      throw ClientError(Code::kDds, "the cancel could not be written");
    }
  }

  // ---- the dispatcher ----

  void dispatch() noexcept {
    MutexLock lock(mutex);
    while (!stopping) {
      if (arrivals.empty()) {
        auto next = Clock::time_point::max();
        const auto given_up = lost(next);
        if (!given_up.empty()) {
          lock.unlock();
          for (const Pending& state : given_up) {
            fail(state,
                 ClientError(Code::kDaemonLost, "the daemon went away and did not come back"));
          }
          lock.lock();
        } else if (next == Clock::time_point::max()) {
          changed.wait(lock);
        } else {
          changed.wait_until(lock, next);
        }
        continue;
      }
      const Arrival arrival = std::move(arrivals.front());
      arrivals.pop_front();
      if (arrival.watched) {
        if (const auto* event = std::get_if<PlanEvent>(&arrival.event)) {
          const OnEvent call = on_watched;
          lock.unlock();
          call(*event);
          lock.lock();
        }
      } else {
        lock.unlock();
        take(arrival);
        lock.lock();
      }
    }
  }

  /// Without the lock: what it calls may come back to us.
  void take(const Arrival& arrival) HANDOVER_EXCLUDES(mutex) {
    const auto* event = std::get_if<PlanEvent>(&arrival.event);
    Pending state;
    std::string fault;
    bool restart = false, late_cancel = false;
    {
      const MutexLock lock(mutex);
      const auto found = pending.find(arrival.id);
      if (found == pending.end()) return;
      state = found->second;
      if (event == nullptr) {
        fault = "unreadable event:" + describe(std::get<std::vector<Fault>>(arrival.event));
      } else {
        if (state->dropped.contains(event->answer_id)) return;
        restart = state->answer != event->answer_id && state->begin(event->answer_id);
        if (event->sequence < state->next_sequence) return;
        if (event->sequence > state->next_sequence) {
          fault = "event " + std::to_string(state->next_sequence) + " is missing before event " +
                  std::to_string(event->sequence);
        } else {
          state->note(*event, arrival.at);
          late_cancel = state->next_sequence == 1 && state->cancel_wanted;
          changed.notify_all();
        }
      }
    }
    if (!fault.empty()) {
      fail(state, ClientError(Code::kBadStream, fault));
      return;
    }
    if (late_cancel) (void)cancels.write(wire::encodeCancel(arrival.id));
    deliver(state, *event, restart, arrival.at);
  }

  /// Calls back, and ends the request with its outcome or with what left a callback.
  void deliver(const Pending& state, const PlanEvent& event, bool restart, Clock::time_point at)
      HANDOVER_EXCLUDES(mutex) {
    try {
      if (restart && state->on_restart) state->on_restart();
      if (state->on_event) state->on_event(event);
    } catch (...) {
      end(state, at);
      state->promise.set_exception(std::current_exception());
      return;
    }
    const auto* outcome = std::get_if<Outcome>(&event.payload);
    if (outcome == nullptr) return;
    end(state, at);
    state->promise.set_value(*outcome);
  }

  /// Forgets a request here and, its instance being unregistered, in the daemon. Without the lock:
  /// writers may be calling back.
  void end(const Pending& state, Clock::time_point at) HANDOVER_EXCLUDES(mutex) {
    {
      const MutexLock lock(mutex);
      state->ended = true;
      state->answered_at = at;
      pending.erase(state->request.id);
      changed.notify_all();
    }
    requests.unregister(wire::encode(state->request));
  }

  void fail(const Pending& state, const ClientError& error) HANDOVER_EXCLUDES(mutex) {
    end(state, Clock::now());
    state->promise.set_exception(std::make_exception_ptr(error));
  }

  /// Requests whose daemon stayed away too long; `next` is when to look again.
  std::vector<Pending> lost(Clock::time_point& next) HANDOVER_REQUIRES(mutex) {
    next = Clock::time_point::max();
    std::vector<Pending> given_up;
    for (const auto& [id, state] : pending) {
      const bool there = state->cell_was_served ? known_daemons.anyServes(state->request.cell)
                                                : !known_daemons.empty();
      if (there) {
        state->lost_at.reset();
        continue;
      }
      if (!state->lost_at) state->lost_at = Clock::now();
      const auto until = *state->lost_at + options.wait;
      if (until <= Clock::now()) {
        given_up.push_back(state);
      } else {
        next = std::min(next, until);
      }
    }
    return given_up;
  }
};

// The handle.

RequestId PlanHandle::id() const { return state_->request.id; }

Outcome PlanHandle::wait() const { return state_->future.get(); }

bool PlanHandle::waitFor(std::chrono::milliseconds most) const {
  return state_->future.wait_for(most) == std::future_status::ready;
}

void PlanHandle::cancel() const {
  const auto client = state_->client.lock();
  if (!client) return;
  {
    // A cancel that overtakes its request would find nothing to cancel.
    const MutexLock lock(client->mutex);
    state_->cancel_wanted = true;
    if (state_->ended || state_->next_sequence == 0) return;
  }
  client->sendCancel(state_->request.id);
}

std::chrono::duration<double> PlanHandle::answerTime() const {
  return state_->answered_at - state_->written_at;
}

std::optional<std::chrono::duration<double>> PlanHandle::firstPlanTime() const {
  if (!state_->planned_at) return std::nullopt;
  return *state_->planned_at - state_->written_at;
}

std::optional<std::chrono::duration<double>> PlanHandle::failureTime() const {
  if (!state_->failed_at) return std::nullopt;
  return *state_->failed_at - state_->written_at;
}

// The client.

Client::Client(const ClientOptions& options) {
  if (!options.client_id.empty() && !validClientId(options.client_id)) {
    throw std::invalid_argument("client id '" + options.client_id +
                                "' must match [a-z0-9_-]{1,64}");
  }
  try {
    impl_ = std::make_shared<Impl>(options);
  } catch (const wire::DdsError& error) {
    throw ClientError(Code::kDds, error.what());
  }
}

Client::~Client() { impl_->shutDown(); }

const std::string& Client::clientId() const { return impl_->client_id; }

PlanHandle Client::plan(PlanRequest request, OnEvent on_event, OnRestart on_restart) {
  if (request.id == RequestId{}) request.id = RequestId::random();
  request.client_id = impl_->client_id;

  PlanHandle handle;
  handle.state_ = std::make_shared<PlanHandle::State>();
  PlanHandle::State& state = *handle.state_;
  state.request = std::move(request);
  state.on_event = std::move(on_event);
  state.on_restart = std::move(on_restart);
  state.client = impl_;

  MutexLock lock(impl_->mutex);
  impl_->awaitDaemon(lock);
  state.written_at = state.answered_at = Clock::now();
  if (auto faults = check(state.request); !faults.empty()) {
    state.ended = true;
    const Outcome outcome = Rejected{RejectionReason::kBadRequest, std::move(faults)};
    lock.unlock();
    if (state.on_event) {
      state.on_event({state.request.id, RequestId::random().bytes, 0, 0, outcome});
    }
    state.promise.set_value(outcome);
    return handle;
  }
  state.cell_was_served = impl_->known_daemons.anyServes(state.request.cell);
  impl_->pending[state.request.id] = handle.state_;
  lock.unlock();
  if (impl_->requests.write(wire::encode(state.request)) != wire::WriteResult::kOk) {
    impl_->end(handle.state_, Clock::now());
    throw ClientError(Code::kDds, "the request could not be written");
  }
  const auto taken = [&state] { return state.next_sequence > 0 || state.ended; };
  lock.lock();
  try {
    if (!impl_->await(lock, Clock::now() + impl_->options.wait, taken)) {
      throw ClientError(Code::kNoDaemon, "no daemon took the request");
    }
  } catch (const ClientError&) {
    if (taken()) return handle;  // who interrupts has something to cancel
    lock.unlock();
    impl_->end(handle.state_, Clock::now());
    throw;
  }
  return handle;
}

void Client::cancel(const RequestId& id) {
  {
    MutexLock lock(impl_->mutex);
    impl_->awaitDaemon(lock);
  }
  impl_->sendCancel(id);
}

std::vector<DaemonStatus> Client::daemons() {
  MutexLock lock(impl_->mutex);
  impl_->awaitDaemon(lock);
  // Where one announced itself the others do so within a period of announcements.
  for (std::size_t known = 0; known != impl_->known_daemons.size();) {
    known = impl_->known_daemons.size();
    impl_->awaitMore(lock, known);
  }
  return impl_->known_daemons.all();
}

bool Client::daemonThere() const {
  const MutexLock lock(impl_->mutex);
  return !impl_->known_daemons.empty();
}

void Client::watch(OnEvent on_event) {
  {
    MutexLock lock(impl_->mutex);
    impl_->awaitDaemon(lock);
    impl_->on_watched = std::move(on_event);
  }
  Impl& impl = *impl_;
  impl.watched.emplace(impl.participant, wire::EntityOptions{.partition = "*"},
                       [&impl](const auto& sample) { impl.onEvent(sample, true); });
}

void routeMiddlewareLog() { wire::routeDdsLog(true); }

void Client::interrupt() {
  const MutexLock lock(impl_->mutex);
  impl_->interrupted = true;
  impl_->changed.notify_all();
}

}  // namespace handover::client
