// SPDX-License-Identifier: Apache-2.0
#include "pending_request.hpp"
#include "shared_participant.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"
#include "wire/known_daemons.hpp"
#include "writer_lease.hpp"

#include <handover/client/client.hpp>
#include <handover/common/check.hpp>
#include <handover/common/domain.hpp>
#include <handover/common/mutex.hpp>

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <thread>

namespace handover::client {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Code = ClientError::Code;

/// Daemons that run already answer a newcomer at about the same time.
constexpr std::chrono::milliseconds kTogether = 40ms;
/// A little more than the period at which participants announce themselves.
constexpr std::chrono::milliseconds kAnnouncements = 300ms;
/// Events of participants that have not announced a daemon yet, until they do.
constexpr std::size_t kMostHeld = 4096;

int domainOf(const ClientOptions& options) {
  if (options.domain) return *options.domain;
  const std::string text = environmentDomain().value_or("0");
  if (const auto domain = parseDomain(text)) return *domain;
  throw std::invalid_argument("HANDOVER_DOMAIN '" + text + "' is not a number from 0 to " +
                              std::to_string(kMaxDomain));
}

std::string randomClientId() { return "client-" + RequestId::random().hex().substr(0, 12); }

}  // namespace

struct Client::Impl {
  using Pending = std::shared_ptr<PlanHandle::State>;
  using RequestWriter = std::shared_ptr<wire::Writer<msg::HandoverRequest>>;

  struct Arrival {
    Clock::time_point at;
    RequestId id;
    wire::Guid writer{};
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
  /// Of participants that have not announced a daemon.
  std::deque<Arrival> held HANDOVER_GUARDED_BY(mutex);
  OnEvent on_watched HANDOVER_GUARDED_BY(mutex);
  bool interrupted HANDOVER_GUARDED_BY(mutex) = false;
  bool stopping HANDOVER_GUARDED_BY(mutex) = false;

  Mutex making;  // held while the event readers are made

  // Last but the thread: their callbacks use all above.
  const std::shared_ptr<const wire::Participant> participant;
  wire::Reader<msg::DaemonStatus> statuses;
  WriterLease<msg::HandoverRequest> requests;
  WriterLease<msg::HandoverCancel> cancels;
  std::optional<wire::Reader<msg::PlanEvent>> events HANDOVER_GUARDED_BY(making);
  std::optional<wire::Reader<msg::PlanEvent>> watched HANDOVER_GUARDED_BY(making);

  std::jthread dispatcher;

  explicit Impl(const ClientOptions& given)
      : options(given),
        domain(domainOf(given)),
        client_id(given.client_id.empty() ? randomClientId() : given.client_id),
        participant(sharedParticipant(domain)),
        statuses(*participant, {.on_match = [this](const auto& match) { onStatusMatch(match); }},
                 [this](const auto& sample) { onStatus(sample); }),
        requests([this] {
          return std::make_shared<wire::Writer<msg::HandoverRequest>>(
              *participant, wire::EntityOptions{.user_data = client_id,
                                                .on_match = [this](const auto&) { touch(); }});
        }),
        cancels([this] {
          return std::make_shared<wire::Writer<msg::HandoverCancel>>(
              *participant, wire::EntityOptions{.on_match = [this](const auto&) { touch(); }});
        }),
        dispatcher([this] { dispatch(); }) {}

  /// Ends the thread; requests still open fail.
  void shutDown() {
    {
      const MutexLock lock(mutex);
      stopping = true;
    }
    changed.notify_all();
    dispatcher.join();
    std::map<RequestId, Pending> open;
    {
      const MutexLock lock(mutex);
      open.swap(pending);
    }
    for (const auto& [id, state] : open) {
      state->writer.reset();
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
    Arrival arrival{Clock::now(), RequestId{sample.key}, sample.writer,
                    wire::decode(*sample.message), by_watch};
    const MutexLock lock(mutex);
    if (known_daemons.announced(arrival.writer)) {
      arrivals.push_back(std::move(arrival));
      changed.notify_all();
    } else if (held.size() < kMostHeld) {
      held.push_back(std::move(arrival));
    }
  }

  void onStatus(const wire::Sample<msg::DaemonStatus>& sample) {
    const MutexLock lock(mutex);
    known_daemons.take(sample);
    const auto unknown = std::stable_partition(
        held.begin(), held.end(), [this](const Arrival& arrival) HANDOVER_REQUIRES(mutex) {
          return known_daemons.announced(arrival.writer);
        });
    std::move(held.begin(), unknown, std::back_inserter(arrivals));
    held.erase(held.begin(), unknown);
    changed.notify_all();
  }

  void onStatusMatch(const wire::Match& match) {
    if (match.gained) return;
    const MutexLock lock(mutex);
    known_daemons.lose(match.peer);
    changed.notify_all();
  }

  // ---- callers' threads ----

  void refuseInCallback(const char* what) const {
    if (std::this_thread::get_id() == dispatcher.get_id()) {
      throw std::logic_error(std::string(what) + " in a callback would wait for itself");
    }
  }

  /// Waits for a condition, at most until `until`; false when it was not met. @throws kInterrupted.
  template <typename Test>
  bool await(MutexLock& lock, Clock::time_point until, Test test) HANDOVER_REQUIRES(mutex) {
    const bool met = changed.wait_until(
        lock, until, [&]() HANDOVER_REQUIRES(mutex) { return interrupted || test(); });
    if (interrupted) throw ClientError(Code::kInterrupted, "interrupted");
    return met && test();
  }

  /// A daemon is announced and has matched the writers: what they write from now on arrives.
  template <typename... Writers>
  void awaitDaemon(MutexLock& lock, const Writers&... writers) HANDOVER_REQUIRES(mutex) {
    const bool there = await(lock, Clock::now() + options.wait, [&]() HANDOVER_REQUIRES(mutex) {
      return !known_daemons.empty() && ((writers->matched() > 0) && ...);
    });
    if (!there) {
      throw ClientError(Code::kNoDaemon, "no daemon in domain " + std::to_string(domain));
    }
  }

  /// Those announced, once there is one, and those that show up with it.
  std::vector<DaemonStatus> daemonsTogether() {
    MutexLock lock(mutex);
    awaitDaemon(lock);
    for (std::size_t known = 0; known != known_daemons.size();) {
      known = known_daemons.size();
      await(lock, Clock::now() + kTogether,
            [this, known]() HANDOVER_REQUIRES(mutex) { return known_daemons.size() > known; });
    }
    // Who has been found has a status that is on its way.
    await(lock, Clock::now() + kAnnouncements, [this]() HANDOVER_REQUIRES(mutex) {
      return statuses.matched() <= static_cast<int>(known_daemons.size());
    });
    return known_daemons.all();
  }

  void makeEventReader() {
    const MutexLock lock(making);
    if (events) return;
    events.emplace(*participant, wire::EntityOptions{.partition = client_id},
                   [this](const auto& sample) { onEvent(sample, false); });
  }

  void makeWatchingReader() {
    const MutexLock lock(making);
    watched.emplace(*participant, wire::EntityOptions{.partition = "*"},
                    [this](const auto& sample) { onEvent(sample, true); });
  }

  void sendCancel(const RequestId& id) {
    const auto writer = cancels.next();
    if (writer->matched() == 0) {
      MutexLock lock(mutex);
      awaitDaemon(lock, writer);
    }
    // Ours end with the instance too, but the message is what other clients can send.
    if (writer->write(wire::encodeCancel(id)) != wire::WriteResult::kOk) {
      throw ClientError(Code::kDds, "the cancel could not be written");
    }
  }

  /// Notes a request that is about to be written. @throws std::invalid_argument.
  void enter(const Pending& state) HANDOVER_REQUIRES(mutex) {
    if (!pending.emplace(state->request.id, state).second) {
      throw std::invalid_argument("request " + state->request.id.hex() + " is being asked for");
    }
    state->written_at = state->heard_at = state->asked_at = state->answered_at = Clock::now();
    state->cell_was_served = known_daemons.anyServes(state->request.cell);
  }

  /// What the wire cannot carry is rejected as the daemon would. False: it can.
  bool rejected(const Pending& state) {
    auto faults = check(state->request);
    if (faults.empty()) return false;
    const Outcome outcome = Rejected{RejectionReason::kBadRequest, std::move(faults)};
    const MutexLock lock(mutex);
    enter(state);
    arrivals.push_back({Clock::now(),
                        state->request.id,
                        {},
                        PlanEvent{state->request.id, RequestId::random().bytes, 0, 0, outcome}});
    changed.notify_all();
    return true;
  }

  void write(const Pending& state) {
    const auto writer = requests.next();
    const auto cancelling = cancels.next();  // so that a cancel need not wait
    {
      MutexLock lock(mutex);
      awaitDaemon(lock, writer, cancelling);
      enter(state);
      state->writer = writer;
    }
    if (writer->write(wire::encode(state->request)) != wire::WriteResult::kOk) {
      throw ClientError(Code::kDds, "the request could not be written");
    }
    MutexLock lock(mutex);
    const auto taken = [&state] { return state->next_sequence > 0 || state->ended; };
    if (!await(lock, Clock::now() + options.wait, taken)) {
      throw ClientError(Code::kNoDaemon, "no daemon took the request");
    }
  }

  /// Writes it and waits until it is taken; who is interrupted then has something to cancel.
  void ask(const Pending& state) {
    try {
      write(state);
    } catch (...) {
      {
        const MutexLock lock(mutex);
        if (state->next_sequence > 0 || state->ended) return;
      }
      end(state, Clock::now());
      throw;
    }
  }

  // ---- the dispatcher ----

  void dispatch() noexcept {
    MutexLock lock(mutex);
    while (!stopping) {
      auto next = Clock::time_point::max();
      if (!arrivals.empty()) {
        const Arrival arrival = std::move(arrivals.front());
        arrivals.pop_front();
        const OnEvent watching = on_watched;
        lock.unlock();
        handle(arrival, watching);
        lock.lock();
      } else if (const auto over = overdue(next); !over.empty()) {
        lock.unlock();
        for (const auto& [state, error] : over) fail(state, error);
        lock.lock();
      } else if (const auto silent = silentOnes(next); !silent.empty()) {
        lock.unlock();
        for (const auto& [writer, request] : silent) (void)writer->write(wire::encode(request));
        lock.lock();
      } else if (next == Clock::time_point::max()) {
        changed.wait(lock);
      } else {
        changed.wait_until(lock, next);
      }
    }
  }

  void handle(const Arrival& arrival, const OnEvent& watching) HANDOVER_EXCLUDES(mutex) {
    if (!arrival.watched) {
      take(arrival);
    } else if (const auto* event = std::get_if<PlanEvent>(&arrival.event)) {
      watching(*event);
    }
  }

  /// Requests whose time is over; `next` is when to look again if there is none.
  std::vector<std::pair<Pending, ClientError>> overdue(Clock::time_point& next)
      HANDOVER_REQUIRES(mutex) {
    const auto now = Clock::now();
    std::vector<std::pair<Pending, ClientError>> over;
    for (const auto& [id, state] : pending) {
      const auto [until, error] = limit(*state, now);
      if (until <= now) {
        over.emplace_back(state, error);
      } else {
        next = std::min(next, until);
      }
    }
    return over;
  }

  /// Requests to ask for again, as nothing was heard of them for `wait`: a daemon that has
  /// forgotten the answer, which a client may sleep through, says so; one that works on it does
  /// nothing.
  std::vector<std::pair<RequestWriter, PlanRequest>> silentOnes(Clock::time_point& next)
      HANDOVER_REQUIRES(mutex) {
    std::vector<std::pair<RequestWriter, PlanRequest>> silent;
    for (const auto& [id, state] : pending) {
      if (state->writer == nullptr) continue;
      const auto now = Clock::now();
      if (std::max(state->heard_at, state->asked_at) + options.wait <= now) {
        silent.emplace_back(state->writer, state->request);
        state->asked_at = now;
      }
      next = std::min(next, std::max(state->heard_at, state->asked_at) + options.wait);
    }
    return silent;
  }

  /// Until when a request may go on, and what it ends with then.
  std::pair<Clock::time_point, ClientError> limit(PlanHandle::State& state, Clock::time_point now)
      HANDOVER_REQUIRES(mutex) {
    const bool there = state.cell_was_served ? known_daemons.anyServes(state.request.cell)
                                             : !known_daemons.empty();
    if (there) {
      state.lost_at.reset();
    } else if (!state.lost_at) {
      state.lost_at = now;
    }
    auto until = state.heard_at + options.silence;
    if (state.request.deadline_s) {
      const std::chrono::duration<double> most(
          std::min(*state.request.deadline_s, kLongestDeadline));
      until = std::min(until, state.written_at + options.wait +
                                  std::chrono::duration_cast<Clock::duration>(most));
    }
    if (state.lost_at && *state.lost_at + options.wait <= until) {
      return {*state.lost_at + options.wait,
              ClientError(Code::kDaemonLost, "the daemon went away and did not come back")};
    }
    return {until, ClientError(Code::kTimeLimit, "the daemon did not answer in time")};
  }

  /// What an event means for its request.
  struct Taken {
    Pending state;  ///< null: nothing
    std::string fault;
    bool restart = false, late_cancel = false;
  };

  Taken note(const Arrival& arrival) {
    const auto* event = std::get_if<PlanEvent>(&arrival.event);
    const MutexLock lock(mutex);
    const auto found = pending.find(arrival.id);
    if (found == pending.end()) return {};
    PlanHandle::State& state = *found->second;
    Taken taken{found->second, {}};
    if (event == nullptr) {
      taken.fault = "unreadable event:" + describe(std::get<std::vector<Fault>>(arrival.event));
      return taken;
    }
    if (state.dropped.contains(event->answer_id)) return {};
    taken.restart = state.answer != event->answer_id && state.begin(event->answer_id);
    if (event->sequence < state.next_sequence) return {};
    if (event->sequence > state.next_sequence) {
      taken.fault = "event " + std::to_string(state.next_sequence) + " is missing before event " +
                    std::to_string(event->sequence);
      return taken;
    }
    state.note(*event, arrival.at);
    taken.late_cancel = state.next_sequence == 1 && state.cancel_wanted;
    changed.notify_all();
    return taken;
  }

  /// Without the lock: what it calls may come back to us.
  void take(const Arrival& arrival) HANDOVER_EXCLUDES(mutex) {
    const Taken taken = note(arrival);
    if (taken.state == nullptr) return;
    if (!taken.fault.empty()) return fail(taken.state, ClientError(Code::kBadStream, taken.fault));
    if (taken.late_cancel) (void)cancels.next()->write(wire::encodeCancel(arrival.id));
    deliver(taken.state, std::get<PlanEvent>(arrival.event), taken.restart, arrival.at);
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

  /// Forgets a request here and, its instance being disposed, in the daemon. Without the lock:
  /// writers may be calling back.
  void end(const Pending& state, Clock::time_point at) HANDOVER_EXCLUDES(mutex) {
    RequestWriter writer;
    {
      const MutexLock lock(mutex);
      state->ended = true;
      state->answered_at = at;
      writer = std::move(state->writer);
      const auto found = pending.find(state->request.id);
      if (found != pending.end() && found->second == state) pending.erase(found);
      changed.notify_all();
    }
    if (writer != nullptr) writer->dispose(wire::encode(state->request));
  }

  void fail(const Pending& state, const ClientError& error) HANDOVER_EXCLUDES(mutex) {
    end(state, Clock::now());
    state->promise.set_exception(std::make_exception_ptr(error));
  }
};

// The handle.

PlanHandle::State& PlanHandle::state() const {
  if (state_ == nullptr) throw std::logic_error("the handle is of no request");
  return *state_;
}

PlanHandle::State& PlanHandle::endedState() const {
  if (!waitFor(0ms)) throw std::logic_error("the request has not ended");
  return *state_;
}

RequestId PlanHandle::id() const { return state().request.id; }

Outcome PlanHandle::wait() const {
  const bool there = waitFor(0ms);
  if (const auto client = state().client.lock(); client && !there)
    client->refuseInCallback("wait()");
  return state().future.get();
}

bool PlanHandle::waitFor(std::chrono::milliseconds most) const {
  return state().future.wait_for(most) == std::future_status::ready;
}

void PlanHandle::cancel() const {
  const auto client = state().client.lock();
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
  const State& ended = endedState();
  return ended.answered_at - ended.written_at;
}

std::optional<std::chrono::duration<double>> PlanHandle::firstPlanTime() const {
  const State& ended = endedState();
  if (!ended.planned_at) return std::nullopt;
  return *ended.planned_at - ended.written_at;
}

std::optional<std::chrono::duration<double>> PlanHandle::failureTime() const {
  const State& ended = endedState();
  if (!ended.failed_at) return std::nullopt;
  return *ended.failed_at - ended.written_at;
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
  impl_->refuseInCallback("plan()");
  if (request.id == RequestId{}) request.id = RequestId::random();
  request.client_id = impl_->client_id;

  PlanHandle handle;
  handle.state_ = std::make_shared<PlanHandle::State>();
  PlanHandle::State& state = *handle.state_;
  state.request = std::move(request);
  state.on_event = std::move(on_event);
  state.on_restart = std::move(on_restart);
  state.client = impl_;

  try {
    impl_->makeEventReader();
    if (!impl_->rejected(handle.state_)) impl_->ask(handle.state_);
  } catch (const wire::DdsError& error) {
    throw ClientError(Code::kDds, error.what());
  }
  return handle;
}

void Client::cancel(const RequestId& id) { impl_->sendCancel(id); }

std::vector<DaemonStatus> Client::daemons() {
  impl_->refuseInCallback("daemons()");
  return impl_->daemonsTogether();
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
  impl_->makeWatchingReader();
}

void routeMiddlewareLog() { wire::routeDdsLog(true); }

void Client::interrupt() {
  const MutexLock lock(impl_->mutex);
  impl_->interrupted = true;
  impl_->changed.notify_all();
}

}  // namespace handover::client
