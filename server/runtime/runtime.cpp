// SPDX-License-Identifier: Apache-2.0
#include "runtime/runtime.hpp"

#include "runtime/thread_name.hpp"

#include <handover/common/check.hpp>
#include <handover/common/log.hpp>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>

namespace handover {
namespace {

using namespace std::chrono_literals;

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
    preparing_.cancel();
    for (const auto& [id, stream] : open_) stream->cancel(CancelCause::kDaemonStopping);
  }
  work_.notify_all();
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

bool Runtime::firstTime(const PlanRequest& request) {
  {
    const MutexLock lock(mutex_);
    if (known_.insert(request.id).second) return true;
    if (std::find(answered_.begin(), answered_.end(), request.id) == answered_.end()) return false;
    ++counters_.rejected;
    changed_ = true;
  }
  Stream again(endpoint_, request);
  send(again, Rejected{RejectionReason::kAlreadyAnswered,
                       {{"request_id", "was answered before: a new request needs a new id"}}});
  return false;
}

void Runtime::onRequest(const PlanRequest& request) {
  CellInfo cell;
  const CellRoute where = route(request.cell, cell);
  if (where == CellRoute::kOthers || !firstTime(request)) return;

  auto stream = std::make_shared<Stream>(endpoint_, request);
  if (where == CellRoute::kNobodys) {
    reject(stream, RejectionReason::kUnknownCell,
           {{"cell", "no daemon serves a cell named '" + request.cell + "'"}});
    return;
  }
  std::uint32_t ahead = 0;
  bool full = false;
  {
    const MutexLock lock(mutex_);
    full = queue_.size() >= settings_.queue_capacity;
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
    return;
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
}

void Runtime::onInvalidRequest(const RequestId& id, const std::string& client_id,
                               const std::vector<Fault>& faults) {
  PlanRequest request;
  request.id = id;
  request.client_id = client_id;
  if (!firstTime(request)) return;
  reject(std::make_shared<Stream>(endpoint_, request), RejectionReason::kBadRequest, faults);
}

void Runtime::onCancel(const RequestId& id, CancelCause cause) {
  StreamPtr queued;
  {
    const MutexLock lock(mutex_);
    const auto found = open_.find(id);
    if (found == open_.end()) return;
    found->second->cancel(cause);
    const auto waiting = std::find(queue_.begin(), queue_.end(), found->second);
    if (waiting != queue_.end()) {
      queued = *waiting;
      queue_.erase(waiting);
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

Outcome Runtime::answer(Stream& stream) {
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
    return service_.plan(stream.request, stream, stream.deadline);
  } catch (const std::exception& error) {
    logger("runtime")->error("request {}: {}", stream.request.id.hex(), error.what());
    return failed(FailureReason::kInternal, "internal", error.what());
  } catch (...) {
    logger("runtime")->error("request {}: unknown exception", stream.request.id.hex());
    return failed(FailureReason::kInternal, "internal", "unknown exception");
  }
}

void Runtime::expireQueued() {
  std::vector<StreamPtr> late;
  {
    const MutexLock lock(mutex_);
    for (auto it = queue_.begin(); it != queue_.end();) {
      if ((*it)->deadline.over()) {
        late.push_back(*it);
        it = queue_.erase(it);
      } else {
        ++it;
      }
    }
  }
  for (const auto& stream : late) {
    finish(stream, failed(FailureReason::kDeadline, "queue", "The deadline passed in the queue."));
  }
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
    status.queued = static_cast<std::uint32_t>(queue_.size());
    status.running = running_;
    status.counters = counters_;
  }
  endpoint_.publishStatus(status);
}

// Threads.

void Runtime::prepareLoop() noexcept {
  nameThread("prepare");
  std::string failure;
  try {
    service_.prepare(preparing_);
  } catch (const std::exception& error) {
    failure = error.what();
  } catch (...) {
    failure = "unknown exception";
  }
  const bool stopped = preparing_.over();
  if (!failure.empty() && !stopped) logger("runtime")->error("preparing failed: {}", failure);
  {
    const MutexLock lock(mutex_);
    ready_ = true;
    changed_ = true;
    if (!stopped && !failure.empty()) prepare_failure_ = "preparing failed: " + failure;
  }
  work_.notify_all();
  report_.notify_one();
  if (!failure.empty() && !stopped && settings_.on_prepare_failed) {
    settings_.on_prepare_failed(failure);
  }
}

void Runtime::workerLoop(int index) noexcept {
  nameThread("worker-" + std::to_string(index));
  while (true) {
    StreamPtr stream;
    {
      MutexLock lock(mutex_);
      work_.wait(lock, [this]() HANDOVER_REQUIRES(mutex_) {
        return stopping_ || (ready_ && !queue_.empty());
      });
      if (stopping_) return;  // stop() answers what is queued
      stream = queue_.front();
      queue_.pop_front();
      ++running_;
      changed_ = true;
    }
    report_.notify_one();
    Outcome outcome = answer(*stream);
    {
      const MutexLock lock(mutex_);
      --running_;
    }
    finish(stream, std::move(outcome));
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
    for (const auto& stream : queue_) {
      if (stream->deadline_at) until = std::min(until, *stream->deadline_at);
    }
    report_.wait_until(lock, until,
                       [this]() HANDOVER_REQUIRES(mutex_) { return stopping_ || changed_; });
  }
}

}  // namespace handover
