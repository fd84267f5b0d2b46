// SPDX-License-Identifier: Apache-2.0
#include "runtime/runtime.hpp"

#include "runtime/thread_name.hpp"

#include <handover/common/check.hpp>
#include <handover/common/log.hpp>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <optional>

namespace handover {
namespace {

using namespace std::chrono_literals;

/// What a request needs can be pushed out of the cache by others before its turn comes.
constexpr int kMostPreparations = 3;

Failed failed(FailureReason reason, std::string filter, const std::string& text) {
  Failed outcome;
  outcome.reason = reason;
  outcome.explanation.filter = std::move(filter);
  outcome.explanation.text = text.substr(0, bounds::kText);
  return outcome;
}

/// Memory that this process has resident; 0 where the system does not say.
std::uint64_t residentBytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  statm >> size >> resident;
  return statm ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::string textOf(const Outcome& outcome) {
  if (const auto* done = std::get_if<Done>(&outcome)) {
    return done->complete ? "done" : "done, cut by the deadline";
  }
  if (const auto* fail = std::get_if<Failed>(&outcome)) {
    return std::string("failed: ") + toString(fail->reason) + " (" + fail->explanation.text + ")";
  }
  if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    return std::string("rejected: ") + toString(rejected->reason);
  }
  return std::string("cancelled: ") + toString(std::get<Cancelled>(outcome).cause);
}

}  // namespace

/// The answer to one request. Used by one thread at a time: who took it from the queue owns it.
class Runtime::Stream : public PlanEventSink {
 public:
  Stream(Endpoint& endpoint, PlanRequest taken)
      : request(std::move(taken)), taken_at(Clock::now()), endpoint_(endpoint) {
    if (!request.deadline_s) return;
    // Deadlines beyond a day are no deadlines; the clock would overflow on absurd ones.
    if (*request.deadline_s < 86'400.0) {
      deadline_at = taken_at + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(*request.deadline_s));
      deadline = Deadline(*deadline_at);
    }
  }

  /// @throws std::logic_error when the payload is beyond what the wire carries.
  void emit(PlanEventPayload payload) override {
    const PlanEvent event{request.id, answer_id_, next_sequence_, elapsed(), std::move(payload)};
    const auto faults = check(event);
    if (!faults.empty()) throw std::logic_error("invalid plan event:" + describe(faults));
    ++next_sequence_;
    endpoint_.publish(request.client_id, event);
  }

  /// Asks planning to stop. From any thread; the first cause is kept.
  void cancel(CancelCause cause) {
    auto none = CancelCause::kUnspecified;
    cancel_cause_.compare_exchange_strong(none, cause);
    deadline.cancel();
  }

  /// What was asked for, where somebody asked; else what planning says of itself.
  Cancelled cancelled(const Cancelled& by_planning) const {
    const CancelCause cause = cancel_cause_;
    return cause == CancelCause::kUnspecified ? by_planning : Cancelled{cause};
  }

  double elapsed() const { return std::chrono::duration<double>(Clock::now() - taken_at).count(); }

  const PlanRequest request;
  const Clock::time_point taken_at;
  std::optional<Clock::time_point> deadline_at;
  Deadline deadline;
  int prepared = 0;  ///< how often what it needs was made for it

 private:
  Endpoint& endpoint_;
  const AnswerId answer_id_ = RequestId::random().bytes;
  std::uint32_t next_sequence_ = 0;
  std::atomic<CancelCause> cancel_cause_ = CancelCause::kUnspecified;
};

Runtime::Runtime(PlanService& service, Endpoint& endpoint, RuntimeSettings settings)
    : service_(service), endpoint_(endpoint), settings_(std::move(settings)) {}

Runtime::~Runtime() { stop(); }

void Runtime::start() {
  threads_.emplace_back([this] { prepareLoop(); });
  for (int i = 0; i < std::max(1, settings_.threads); ++i) {
    threads_.emplace_back([this, i] { workerLoop(i); });
  }
  threads_.emplace_back([this] { statusLoop(); });
  endpoint_.open(*this);
}

void Runtime::stop() {
  endpoint_.stopReceiving();
  std::deque<StreamPtr> queued;
  {
    const MutexLock lock(mutex_);
    if (stopping_) return;
    stopping_ = true;
    queued.swap(queue_);
    queued.insert(queued.end(), unprepared_.begin(), unprepared_.end());
    unprepared_.clear();
    preparing_.cancel();
    for (const auto& [id, stream] : open_) stream->cancel(CancelCause::kDaemonStopping);
  }
  work_.notify_all();
  lacks_.notify_all();
  report_.notify_all();
  for (const auto& stream : queued) finish(stream, Cancelled{CancelCause::kDaemonStopping});
  threads_.clear();  // joins
  publishStatus();
  endpoint_.flush(2s);
}

// Requests, on the endpoint's threads.

Runtime::CellRoute Runtime::route(const std::string& cell, CellInfo& info) const {
  for (CellInfo& ours : service_.cells()) {
    if (ours.name != cell) continue;
    info = std::move(ours);
    return CellRoute::kOurs;
  }
  // Of the daemons that are there, the one of lowest id answers for a cell that none of them has.
  for (const DaemonStatus& other : endpoint_.others()) {
    if (serves(other, cell) || other.id < settings_.id) return CellRoute::kOthers;
  }
  return CellRoute::kNobodys;
}

Runtime::Asked Runtime::asked(const PlanRequest& request) {
  {
    const MutexLock lock(mutex_);
    if (known_.insert(request.id).second) return Asked::kFirst;
    const auto open = open_.find(request.id);
    const bool same_client =
        open != open_.end() && open->second->request.client_id == request.client_id;
    if (same_client) return Asked::kMeanwhile;
    ++counters_.rejected;
    changed_ = true;
  }
  Stream again(endpoint_, request);
  send(again, Rejected{RejectionReason::kAlreadyAnswered,
                       {{"request_id", "was asked before: a new request needs a new id"}}});
  return Asked::kAgain;
}

bool Runtime::onRequest(const PlanRequest& request) {
  CellInfo cell;
  const CellRoute where = route(request.cell, cell);
  if (where == CellRoute::kOthers) return false;
  if (const Asked how = asked(request); how != Asked::kFirst) return how == Asked::kAgain;

  auto stream = std::make_shared<Stream>(endpoint_, request);
  if (where == CellRoute::kNobodys) {
    reject(stream, RejectionReason::kUnknownCell,
           {{"cell", "no daemon serves a cell named '" + request.cell + "'"}});
    return true;
  }
  std::uint32_t ahead = 0;
  bool full = false;
  {
    const MutexLock lock(mutex_);
    full = waiting() >= settings_.queue_capacity;
    ahead = static_cast<std::uint32_t>(queue_.size()) + running_;
    if (!full) {
      open_[request.id] = stream;
      ++counters_.accepted;
    }
  }
  if (full) {
    reject(stream, RejectionReason::kBusy,
           {{"",
             "the queue is full: " + std::to_string(settings_.queue_capacity) + " requests wait"}});
    return true;
  }
  Accepted accepted;
  accepted.daemon_id = settings_.id;
  accepted.program_version = settings_.version;
  accepted.scene_revision = cell.revision;
  accepted.scene_hash = cell.scene_hash;
  accepted.queue_place = ahead;
  stream->emit(std::move(accepted));
  {
    // Only this thread adds to the queue, so there is still room.
    const MutexLock lock(mutex_);
    queue_.push_back(stream);
    changed_ = true;
  }
  work_.notify_one();
  report_.notify_one();
  return true;
}

bool Runtime::onInvalidRequest(const RequestId& id, const std::string& client_id,
                               const std::vector<Fault>& faults) {
  PlanRequest request;
  request.id = id;
  request.client_id = client_id;
  if (const Asked how = asked(request); how != Asked::kFirst) return how == Asked::kAgain;
  reject(std::make_shared<Stream>(endpoint_, request), RejectionReason::kBadRequest, faults);
  return true;
}

void Runtime::onCancel(const RequestId& id, CancelCause cause) {
  StreamPtr queued;
  {
    const MutexLock lock(mutex_);
    const auto found = open_.find(id);
    if (found == open_.end()) return;
    found->second->cancel(cause);
    for (std::deque<StreamPtr>* waiting : {&queue_, &unprepared_}) {
      const auto at = std::find(waiting->begin(), waiting->end(), found->second);
      if (at == waiting->end()) continue;
      queued = *at;
      waiting->erase(at);
    }
  }
  if (queued) finish(queued, Cancelled{cause});
}

void Runtime::reject(const StreamPtr& stream, RejectionReason reason, std::vector<Fault> faults) {
  finish(stream, Rejected{reason, std::move(faults)});
}

// Answers.

void Runtime::finish(const StreamPtr& stream, Outcome outcome) {
  if (auto* cancelled = std::get_if<Cancelled>(&outcome)) {
    *cancelled = stream->cancelled(*cancelled);
  }
  {
    // Counted before it is sent: who has the outcome may ask for the counters.
    const MutexLock lock(mutex_);
    if (std::holds_alternative<Done>(outcome)) ++counters_.done;
    if (std::holds_alternative<Failed>(outcome)) ++counters_.failed;
    if (std::holds_alternative<Cancelled>(outcome)) ++counters_.cancelled;
    if (std::holds_alternative<Rejected>(outcome)) ++counters_.rejected;
    open_.erase(stream->request.id);
    answered_.push_back(stream->request.id);
    while (answered_.size() > settings_.remembered) {
      known_.erase(answered_.front());
      answered_.pop_front();
    }
    changed_ = true;
  }
  send(*stream, std::move(outcome));
  report_.notify_one();
}

void Runtime::send(Stream& stream, Outcome outcome) {
  const std::string text = textOf(outcome);
  const std::string id = stream.request.id.hex();
  try {
    stream.emit(std::move(outcome));
  } catch (const std::logic_error& error) {
    logger("runtime")->error("request {}: {}", id, error.what());
    stream.emit(failed(FailureReason::kInternal, "runtime", "The outcome cannot be sent."));
  }
  logger("runtime")->info("request {} of {}: {}, {:.1f} ms", id, stream.request.client_id, text,
                          1e3 * stream.elapsed());
}

bool Runtime::othersWait() const {
  const MutexLock lock(mutex_);
  return !queue_.empty();
}

/// nullopt: something has to be made first.
std::optional<Outcome> Runtime::answer(Stream& stream) {
  switch (stream.deadline.state()) {
    case Deadline::State::kCancelled:
      return Cancelled{};
    case Deadline::State::kPassed:
      return failed(FailureReason::kDeadline, "queue", "The deadline passed in the queue.");
    case Deadline::State::kOpen:
      break;
  }
  {
    const MutexLock lock(mutex_);
    if (!prepare_failure_.empty()) {
      return failed(FailureReason::kInternal, "prepare", prepare_failure_);
    }
  }
  // The one catch for broken promises of our own: the request fails, the daemon lives.
  try {
    if (stream.prepared > kMostPreparations) {
      return failed(FailureReason::kInternal, "prepare", "What it needs is gone as soon as made.");
    }
    return service_.plan(stream.request, stream, stream.deadline, [this] { return othersWait(); });
  } catch (const std::exception& error) {
    logger("runtime")->error("request {}: {}", stream.request.id.hex(), error.what());
    return failed(FailureReason::kInternal, "internal", error.what());
  } catch (...) {
    logger("runtime")->error("request {}: unknown exception", stream.request.id.hex());
    return failed(FailureReason::kInternal, "internal", "unknown exception");
  }
}

void Runtime::expire(std::deque<StreamPtr>& waiting, std::vector<StreamPtr>& late) {
  for (auto it = waiting.begin(); it != waiting.end();) {
    if ((*it)->deadline.over()) {
      late.push_back(*it);
      it = waiting.erase(it);
    } else {
      ++it;
    }
  }
}

void Runtime::expireQueued() {
  std::vector<StreamPtr> late;
  {
    const MutexLock lock(mutex_);
    expire(queue_, late);
    expire(unprepared_, late);
  }
  for (const auto& stream : late) {
    finish(stream, failed(FailureReason::kDeadline, "queue", "The deadline passed in the queue."));
  }
}

std::uint32_t Runtime::waiting() const {
  return static_cast<std::uint32_t>(queue_.size() + unprepared_.size()) + being_prepared_;
}

void Runtime::publishStatus() {
  DaemonStatus status;
  status.id = settings_.id;
  status.version = settings_.version;
  status.cells = service_.cells();
  status.memory_bytes = residentBytes();
  {
    const MutexLock lock(mutex_);
    changed_ = false;
    status.state = stopping_ ? DaemonState::kStopping
                   : ready_  ? DaemonState::kReady
                             : DaemonState::kPreparing;
    status.queued = waiting();
    status.running = running_;
    status.counters = counters_;
  }
  endpoint_.publishStatus(status);
}

// Threads.

Runtime::StreamPtr Runtime::nextUnprepared(bool& stop) {
  MutexLock lock(mutex_);
  lacks_.wait(lock, [this]() HANDOVER_REQUIRES(mutex_) {
    return stopping_ || !ready_ || !unprepared_.empty();
  });
  stop = stopping_;
  if (stop || unprepared_.empty()) return nullptr;
  StreamPtr stream = unprepared_.front();
  unprepared_.pop_front();
  ++being_prepared_;
  return stream;
}

/// Makes what a request lacks and queues it again, before those that came after it.
void Runtime::prepareRequest(const StreamPtr& stream) {
  std::optional<Outcome> failure;
  ++stream->prepared;
  try {
    service_.prepare(stream->request, stream->deadline);
  } catch (const std::exception& error) {
    if (!stream->deadline.over())
      failure = failed(FailureReason::kInternal, "prepare", error.what());
  } catch (...) {
    failure = failed(FailureReason::kInternal, "prepare", "unknown exception");
  }
  {
    const MutexLock lock(mutex_);
    --being_prepared_;
    changed_ = true;
    if (!failure && stopping_) failure = Cancelled{CancelCause::kDaemonStopping};
    if (!failure && stream->deadline.state() == Deadline::State::kPassed) {
      failure = failed(FailureReason::kDeadline, "prepare",
                       "The deadline passed while parts, maps or grasps were made.");
    }
    if (!failure) {
      const auto later = [&](const StreamPtr& it) { return it->taken_at > stream->taken_at; };
      queue_.insert(std::find_if(queue_.begin(), queue_.end(), later), stream);
    }
  }
  if (failure) return finish(stream, std::move(*failure));
  work_.notify_one();
}

/// One more cell; where none is left, or one cannot be prepared, the daemon is ready.
void Runtime::prepareCell() {
  bool more = false;
  std::string failure;
  try {
    more = service_.prepareNext(preparing_);
  } catch (const std::exception& error) {
    failure = error.what();
  } catch (...) {
    failure = "unknown exception";
  }
  if (more || preparing_.over()) return;
  if (!failure.empty()) logger("runtime")->error("preparing failed: {}", failure);
  {
    const MutexLock lock(mutex_);
    ready_ = true;
    changed_ = true;
    if (!failure.empty()) prepare_failure_ = "preparing failed: " + failure;
  }
  report_.notify_one();
  if (!failure.empty() && settings_.on_prepare_failed) settings_.on_prepare_failed(failure);
}

void Runtime::prepareLoop() noexcept {
  nameThread("prepare");
  while (true) {
    bool stop = false;
    const StreamPtr stream = nextUnprepared(stop);
    if (stop) return;
    if (stream) {
      prepareRequest(stream);
    } else {
      prepareCell();
    }
  }
}

void Runtime::workerLoop(int index) noexcept {
  nameThread("worker-" + std::to_string(index));
  while (true) {
    StreamPtr stream;
    {
      MutexLock lock(mutex_);
      work_.wait(lock, [this]() HANDOVER_REQUIRES(mutex_) { return stopping_ || !queue_.empty(); });
      if (stopping_) return;  // stop() answers what is queued
      stream = queue_.front();
      queue_.pop_front();
      ++running_;
      changed_ = true;
    }
    report_.notify_one();
    std::optional<Outcome> outcome = answer(*stream);
    {
      const MutexLock lock(mutex_);
      --running_;
      if (!outcome && stopping_) outcome = Cancelled{CancelCause::kDaemonStopping};
      if (!outcome) unprepared_.push_back(stream);
      changed_ = true;
    }
    if (outcome) finish(stream, std::move(*outcome));
    lacks_.notify_one();
    report_.notify_one();
  }
}

void Runtime::statusLoop() noexcept {
  nameThread("status");
  while (true) {
    expireQueued();
    publishStatus();
    MutexLock lock(mutex_);
    if (stopping_) return;
    // At most 20 reports a second, at least one; queued deadlines in time.
    report_.wait_for(lock, 50ms, [this]() HANDOVER_REQUIRES(mutex_) { return stopping_; });
    auto until = Clock::now() + 950ms;
    for (const std::deque<StreamPtr>* waiting : {&queue_, &unprepared_}) {
      for (const auto& stream : *waiting) {
        if (stream->deadline_at) until = std::min(until, *stream->deadline_at);
      }
    }
    report_.wait_until(lock, until,
                       [this]() HANDOVER_REQUIRES(mutex_) { return stopping_ || changed_; });
  }
}

}  // namespace handover
