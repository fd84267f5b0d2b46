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
  OnStage on_stage;
  std::weak_ptr<Client::Impl> client;
  std::promise<Outcome> promise;
  std::shared_future<Outcome> future = promise.get_future().share();

  // Guarded by the client's mutex.
  Clock::time_point written_at{}, answered_at{};
  std::optional<Clock::time_point> planned_at;  ///< the first whole plan was there
  std::map<std::uint32_t, int> stages_seen;     ///< by solution
  std::uint32_t next_sequence = 0;
  bool ended = false;
  bool cell_was_served = false;
  bool cancel_wanted = false;
  std::optional<Clock::time_point> lost_at;
};

struct Client::Impl {
  using Pending = std::shared_ptr<PlanHandle::State>;

  struct Event {
    Clock::time_point at;
    RequestId id;
    wire::Decoded<PlanStage> stage;
    bool watched = false;
  };

  const ClientOptions options;
  const int domain;
  const std::string client_id;

  Mutex mutex;
  Condition changed;
  wire::KnownDaemons known_daemons HANDOVER_GUARDED_BY(mutex);
  std::map<RequestId, Pending> pending HANDOVER_GUARDED_BY(mutex);
  std::deque<Event> events HANDOVER_GUARDED_BY(mutex);
  OnStage on_watched HANDOVER_GUARDED_BY(mutex);
  bool interrupted HANDOVER_GUARDED_BY(mutex) = false;
  bool stopping HANDOVER_GUARDED_BY(mutex) = false;

  // Last but the thread: their callbacks use all above.
  wire::Participant participant;
  wire::Writer<msg::HandoverRequest> requests;
  wire::Writer<msg::HandoverCancel> cancels;
  wire::Reader<msg::PlanStage> stages;
  wire::Reader<msg::DaemonStatus> statuses;
  std::optional<wire::Reader<msg::PlanStage>> watched;

  std::jthread dispatcher;

  explicit Impl(const ClientOptions& given)
      : options(given),
        domain(domainOf(given)),
        client_id(given.client_id.empty() ? randomClientId() : given.client_id),
        participant({.domain = domain, .name = "handover client", .on_writer = {}}),
        requests(participant,
                 {.user_data = client_id, .on_match = [this](const auto&) { touch(); }}),
        cancels(participant, {.on_match = [this](const auto&) { touch(); }}),
        stages(participant, {.partition = client_id, .on_match = [this](const auto&) { touch(); }},
               [this](const auto& sample) { onStage(sample, false); }),
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

  void onStage(const wire::Sample<msg::PlanStage>& sample, bool by_watch) {
    if (sample.message == nullptr) return;
    Event event{Clock::now(), RequestId{sample.key}, wire::decode(*sample.message), by_watch};
    const MutexLock lock(mutex);
    events.push_back(std::move(event));
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
    // The daemon makes our stage writer as soon as it sees our request writer. One that does not
    // know us makes it with the first request; its stages wait for us then.
    using namespace std::chrono_literals;
    await(lock, std::min(until, Clock::now() + 500ms), [this] { return stages.matched() > 0; });
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
      if (events.empty()) {
        auto next = Clock::time_point::max();
        const auto given_up = lost(next);
        if (!given_up.empty()) {
          lock.unlock();
          for (const Pending& state : given_up) {
            fail(state, Code::kDaemonLost, "the daemon went away and did not come back");
          }
          lock.lock();
        } else if (next == Clock::time_point::max()) {
          changed.wait(lock);
        } else {
          changed.wait_until(lock, next);
        }
        continue;
      }
      Event event = std::move(events.front());
      events.pop_front();
      if (event.watched) {
        if (const auto* stage = std::get_if<PlanStage>(&event.stage)) {
          const OnStage call = on_watched;
          lock.unlock();
          call(*stage);
          lock.lock();
        }
      } else {
        lock.unlock();
        take(event);
        lock.lock();
      }
    }
  }

  /// Without the lock: what it calls may come back to us.
  void take(const Event& event) HANDOVER_EXCLUDES(mutex) {
    const auto* stage = std::get_if<PlanStage>(&event.stage);
    Pending state;
    std::string fault;
    bool late_cancel = false;
    {
      const MutexLock lock(mutex);
      const auto found = pending.find(event.id);
      if (found == pending.end()) return;
      state = found->second;
      if (stage == nullptr) {
        fault = "unreadable stage:" + describe(std::get<std::vector<Fault>>(event.stage));
      } else if (stage->sequence < state->next_sequence) {
        return;  // a daemon that came back sends the same stages again from the first on
      } else if (stage->sequence > state->next_sequence) {
        fault = "stage " + std::to_string(state->next_sequence) + " is missing before stage " +
                std::to_string(stage->sequence);
      } else {
        late_cancel = note(*state, *stage, event.at);
      }
    }
    if (!fault.empty()) {
      fail(state, Code::kBadStream, fault);
      return;
    }
    if (late_cancel) (void)cancels.write(wire::encodeCancel(event.id));
    if (state->on_stage) state->on_stage(*stage);
    const auto* outcome = std::get_if<Outcome>(&stage->payload);
    if (outcome != nullptr) {
      end(state, event.at);
      state->promise.set_value(*outcome);
    }
  }

  /// The next stage is there; true when a cancel waited for the first one.
  bool note(PlanHandle::State& state, const PlanStage& stage, Clock::time_point at)
      HANDOVER_REQUIRES(mutex) {
    ++state.next_sequence;
    if (const auto* path = std::get_if<StageTrajectory>(&stage.payload)) {
      const bool whole = ++state.stages_seen[path->solution] == kStageCount;
      if (whole && !state.planned_at) state.planned_at = at;
    }
    changed.notify_all();
    return state.next_sequence == 1 && state.cancel_wanted;
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

  void fail(const Pending& state, Code code, const std::string& text) HANDOVER_EXCLUDES(mutex) {
    end(state, Clock::now());
    state->promise.set_exception(std::make_exception_ptr(ClientError(code, text)));
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

// ---- handle
// --------------------------------------------------------------------------------------------

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

// ---- client
// --------------------------------------------------------------------------------------------

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

PlanHandle Client::plan(PlanRequest request, OnStage on_stage) {
  if (request.id == RequestId{}) request.id = RequestId::random();
  request.client_id = impl_->client_id;

  PlanHandle handle;
  handle.state_ = std::make_shared<PlanHandle::State>();
  PlanHandle::State& state = *handle.state_;
  state.request = std::move(request);
  state.on_stage = std::move(on_stage);
  state.client = impl_;

  MutexLock lock(impl_->mutex);
  impl_->awaitDaemon(lock);
  state.written_at = state.answered_at = Clock::now();
  if (auto faults = check(state.request); !faults.empty()) {
    state.ended = true;
    const PlanStage stage{state.request.id, 0, 0, Outcome{Rejected{"bad_request", faults}}};
    lock.unlock();
    if (state.on_stage) state.on_stage(stage);
    state.promise.set_value(std::get<Outcome>(stage.payload));
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

void Client::watch(OnStage on_stage) {
  {
    MutexLock lock(impl_->mutex);
    impl_->awaitDaemon(lock);
    impl_->on_watched = std::move(on_stage);
  }
  Impl& impl = *impl_;
  impl.watched.emplace(impl.participant, wire::EntityOptions{.partition = "*"},
                       [&impl](const auto& sample) { impl.onStage(sample, true); });
}

void routeMiddlewareLog() { wire::routeDdsLog(true); }

void Client::interrupt() {
  const MutexLock lock(impl_->mutex);
  impl_->interrupted = true;
  impl_->changed.notify_all();
}

}  // namespace handover::client
