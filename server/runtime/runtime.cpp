// SPDX-License-Identifier: Apache-2.0
#include "runtime/runtime.hpp"

#include "runtime/memory.hpp"
#include "runtime/request_log.hpp"
#include "runtime/thread_name.hpp"
#include "settings/yaml_reader.hpp"

#include <handover/common/check.hpp>
#include <handover/common/log.hpp>

#include <algorithm>
#include <atomic>
#include <optional>

namespace handover {
namespace {

using namespace std::chrono_literals;

/// What a request needs can be pushed out of the cache by others before its turn comes.
constexpr int kMostPreparations = 3;

/// Memory is given back this long after the last time, at the first quiet moment.
constexpr auto kTrimPeriod = 5s;

Failed failed(FailureReason reason, std::string filter, const std::string& text) {
  Failed outcome;
  outcome.reason = reason;
  outcome.explanation.filter = std::move(filter);
  outcome.explanation.text = text.substr(0, bounds::kText);
  return outcome;
}

/// What any daemon that is there serves.
std::vector<CellInfo> cellsOfAll(const ServedCells& served, const Endpoint& endpoint) {
  std::vector<CellInfo> cells = served.infos;
  for (const DaemonStatus& other : endpoint.others()) {
    cells.insert(cells.end(), other.cells.begin(), other.cells.end());
  }
  return cells;
}

}  // namespace

/// The answer to one request. Used by one thread at a time: who took it from the queue owns it.
class Runtime::Stream : public PlanEventSink {
 public:
  /// @param served  cells from which it is answered; null for one that none of them is asked for
  /// @param patience_s  its deadline where it names none
  Stream(Endpoint& endpoint, PlanRequest taken, CellsPtr served = nullptr,
         std::optional<double> patience_s = {})
      : request(std::move(taken)),
        cells(std::move(served)),
        taken_at(Clock::now()),
        endpoint_(endpoint) {
    facts.task = request.task;
    const std::optional<double> seconds = request.deadline_s ? request.deadline_s : patience_s;
    if (!seconds || *seconds >= kLongestDeadline) return;
    deadline_at = taken_at + std::chrono::duration_cast<Clock::duration>(
                                 std::chrono::duration<double>(*seconds));
    deadline = Deadline(*deadline_at);
  }

  /// @throws std::logic_error when the payload is beyond what the wire carries.
  void emit(PlanEventPayload payload) override {
    const PlanEvent event{request.id, answer_id_, next_sequence_, elapsed(), std::move(payload)};
    const auto faults = check(event);
    if (!faults.empty()) throw std::logic_error("invalid plan event:" + describe(faults));
    ++next_sequence_;
    note(event.payload);
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
  const CellsPtr cells;
  const Clock::time_point taken_at;
  std::optional<Clock::time_point> deadline_at;
  Deadline deadline;
  int prepared = 0;  ///< how often what it needs was made for it
  // Guarded by the runtime's mutex.
  std::uint64_t place = 0;  ///< among the requests accepted
  bool on_worker = false;   ///< from its turn on, but while it lacks something
  AnswerFacts facts;

 private:
  /// What the log will tell.
  void note(const PlanEventPayload& payload) {
    if (const auto* accepted = std::get_if<Accepted>(&payload)) {
      facts.scene_hash = accepted->scene_hash;
    } else if (const auto* scene = std::get_if<SceneSnapshot>(&payload)) {
      facts.task = scene->task;
      facts.scene_hash = scene->scene_hash;
    }
  }

  Endpoint& endpoint_;
  const AnswerId answer_id_ = RequestId::random().bytes;
  std::uint32_t next_sequence_ = 0;
  std::atomic<CancelCause> cancel_cause_ = CancelCause::kUnspecified;
};

Runtime::Runtime(PlanService& service, Endpoint& endpoint, RuntimeSettings settings)
    : service_(service),
      endpoint_(endpoint),
      settings_(std::move(settings)),
      accounts_(settings_.client_limits) {}

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
  std::vector<StreamPtr> queued;
  {
    const MutexLock lock(mutex_);
    if (stopping_) return;
    stopping_ = true;
    queued = extract([](const StreamPtr&) { return true; });
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

void Runtime::reload(const Deadline& deadline) {
  const auto log = logger("runtime");
  try {
    service_.reload(deadline);
  } catch (const std::exception& error) {
    log->error("the cells stay as they are: {}", error.what());
    return;
  }
  log->info("the cells were read again");
  {
    const MutexLock lock(mutex_);
    ready_ = false;
    changed_ = true;
  }
  lacks_.notify_one();
  report_.notify_one();
}

// Requests, on the endpoint's threads.

Runtime::CellRoute Runtime::route(const ServedCells& served, const std::string& cell,
                                  CellInfo& info) const {
  for (const CellInfo& ours : served.infos) {
    if (ours.name != cell) continue;
    info = ours;
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

std::string Runtime::admit(const StreamPtr& stream, std::uint32_t& ahead) {
  const std::string& client = stream->request.client_id;
  const MutexLock lock(mutex_);
  if (waiting() >= settings_.queue_capacity) {
    return fmt::format("the queue is full: {} requests wait", settings_.queue_capacity);
  }
  const auto of_client = std::count_if(open_.begin(), open_.end(), [&](const auto& open) {
    return open.second->request.client_id == client && !open.second->on_worker;
  });
  if (static_cast<std::size_t>(of_client) >= settings_.client_queue) {
    return fmt::format("{} requests of this client wait, as many as may", settings_.client_queue);
  }
  if (std::string why_not = accounts_.refusal(client, Clock::now()); !why_not.empty()) {
    return why_not;
  }
  ahead = static_cast<std::uint32_t>(queue_.ahead(client)) + running_;
  stream->place = counters_.accepted++;
  open_[stream->request.id] = stream;
  return "";
}

bool Runtime::onRequest(const PlanRequest& request) {
  const CellsPtr served = service_.served();
  CellInfo cell;
  const CellRoute where = route(*served, request.cell, cell);
  if (where == CellRoute::kOthers) return false;
  if (const Asked how = asked(request); how != Asked::kFirst) return how == Asked::kAgain;

  auto stream = std::make_shared<Stream>(endpoint_, request, served, settings_.deadline_s);
  if (where == CellRoute::kNobodys) {
    reject(stream, RejectionReason::kUnknownCell,
           {{"cell", "no daemon serves a cell named '" + request.cell + "'" +
                         nearestNamed(cellsOfAll(*served, endpoint_), request.cell)}});
    return true;
  }
  std::uint32_t ahead = 0;
  if (const std::string why_not = admit(stream, ahead); !why_not.empty()) {
    reject(stream, RejectionReason::kBusy, {{"", why_not}});
    return true;
  }
  Accepted accepted;
  accepted.daemon_id = settings_.id;
  accepted.program_version = settings_.version;
  accepted.scene_revision = cell.revision;
  accepted.scene_hash = cell.scene_hash;
  accepted.queue_place = ahead;
  stream->emit(std::move(accepted));
  logger("runtime")->debug("request {} of {}: accepted, {} ahead", request.id.hex(),
                           request.client_id, ahead);
  {
    // Only this thread adds to the queue, so there is still room.
    const MutexLock lock(mutex_);
    queue_.push(request.client_id, stream->place, stream);
    changed_ = true;
  }
  work_.notify_one();
  report_.notify_one();
  return true;
}

bool Runtime::onInvalidRequest(const RequestId& id, const std::string& client_id,
                               const std::vector<Fault>& faults) {
  // One daemon of the domain says so: that of lowest id.
  for (const DaemonStatus& other : endpoint_.others()) {
    if (other.id < settings_.id) return false;
  }
  PlanRequest request;
  request.id = id;
  request.client_id = client_id;
  if (const Asked how = asked(request); how != Asked::kFirst) return how == Asked::kAgain;
  reject(std::make_shared<Stream>(endpoint_, request), RejectionReason::kBadRequest, faults);
  return true;
}

void Runtime::onCancel(const RequestId& id, CancelCause cause) {
  std::vector<StreamPtr> queued;
  {
    const MutexLock lock(mutex_);
    const auto found = open_.find(id);
    if (found == open_.end()) return;
    found->second->cancel(cause);
    queued = extract([&](const StreamPtr& stream) { return stream == found->second; });
  }
  for (const auto& stream : queued) finish(stream, Cancelled{cause});
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
  if (stream.facts.queued_s == 0) stream.facts.queued_s = stream.elapsed();  // no worker took it
  try {
    stream.emit(outcome);
  } catch (const std::logic_error& error) {
    logger("runtime")->error("request {}: {}", stream.request.id.hex(), error.what());
    outcome = failed(FailureReason::kInternal, "runtime", "The outcome cannot be sent.");
    stream.emit(outcome);
  }
  logAnswer(stream.request, stream.facts, outcome);
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
    return service_.plan(*stream.cells, stream.request, stream, stream.deadline,
                         [this] { return othersWait(); });
  } catch (const std::exception& error) {
    logger("runtime")->error("request {}: {}", stream.request.id.hex(), error.what());
    return failed(FailureReason::kInternal, "internal", error.what());
  } catch (...) {
    logger("runtime")->error("request {}: unknown exception", stream.request.id.hex());
    return failed(FailureReason::kInternal, "internal", "unknown exception");
  }
}

template <typename Condition>
std::vector<Runtime::StreamPtr> Runtime::extract(Condition condition) {
  std::vector<StreamPtr> taken = queue_.extract(condition);
  std::vector<StreamPtr> more = unprepared_.extract(condition);
  taken.insert(taken.end(), more.begin(), more.end());
  return taken;
}

void Runtime::expireQueued() {
  std::vector<StreamPtr> late;
  {
    const MutexLock lock(mutex_);
    late = extract([](const StreamPtr& stream) { return stream->deadline.over(); });
  }
  for (const auto& stream : late) {
    // A cancel may have come while it was in no queue.
    if (stream->deadline.state() == Deadline::State::kCancelled) {
      finish(stream, Cancelled{});
    } else {
      finish(stream,
             failed(FailureReason::kDeadline, "queue", "The deadline passed in the queue."));
    }
  }
}

std::uint32_t Runtime::waiting() const {
  return static_cast<std::uint32_t>(queue_.size() + unprepared_.size()) + being_prepared_;
}

void Runtime::publishStatus() {
  DaemonStatus status;
  status.id = settings_.id;
  status.version = settings_.version;
  status.cells = service_.served()->infos;
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
  ++being_prepared_;
  return unprepared_.pop();
}

/// Makes what a request lacks and queues it again, before those that came after it.
void Runtime::prepareRequest(const StreamPtr& stream) {
  std::optional<Outcome> failure;
  std::uint64_t cache_bytes = 0;
  ++stream->prepared;
  const double began_s = stream->elapsed();
  logger("runtime")->debug("request {}: what it lacks is made", stream->request.id.hex());
  try {
    cache_bytes = service_.prepare(*stream->cells, stream->request, stream->deadline);
  } catch (const std::exception& error) {
    if (!stream->deadline.over())
      failure = failed(FailureReason::kInternal, "prepare", error.what());
  } catch (...) {
    failure = failed(FailureReason::kInternal, "prepare", "unknown exception");
  }
  const double took_s = stream->elapsed() - began_s;
  stream->facts.prepared_s += took_s;
  {
    const MutexLock lock(mutex_);
    --being_prepared_;
    unprepared_.finished(stream->request.client_id, took_s);
    accounts_.charge(stream->request.client_id, took_s, cache_bytes, Clock::now());
    changed_ = true;
    if (!failure && stopping_) failure = Cancelled{CancelCause::kDaemonStopping};
    if (!failure && stream->deadline.state() == Deadline::State::kPassed) {
      failure = failed(FailureReason::kDeadline, "prepare",
                       "The deadline passed while parts, maps or grasps were made.");
    }
    if (!failure) queue_.push(stream->request.client_id, stream->place, stream);
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
  if (failure.empty()) {
    logger("runtime")->info("ready: all cells are prepared");
  } else {
    logger("runtime")->error("preparing failed: {}", failure);
  }
  bool fatal = false;
  {
    const MutexLock lock(mutex_);
    // Cells that were read again fail their own requests; others go on.
    fatal = !failure.empty() && !was_ready_;
    ready_ = was_ready_ = true;
    changed_ = true;
    if (fatal) prepare_failure_ = "preparing failed: " + failure;
  }
  report_.notify_one();
  if (fatal && settings_.on_prepare_failed) settings_.on_prepare_failed(failure);
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
      stream = queue_.pop();
      stream->on_worker = true;
      ++running_;
      changed_ = true;
    }
    report_.notify_one();
    AnswerFacts& facts = stream->facts;
    const double began_s = stream->elapsed();
    if (facts.queued_s == 0) facts.queued_s = began_s;
    std::optional<Outcome> outcome = answer(*stream);
    const double took_s = stream->elapsed() - began_s;
    facts.planned_s += took_s;
    {
      const std::string& client = stream->request.client_id;
      const MutexLock lock(mutex_);
      --running_;
      queue_.finished(client, took_s);
      accounts_.charge(client, took_s, 0, Clock::now());
      if (!outcome && stopping_) outcome = Cancelled{CancelCause::kDaemonStopping};
      stream->on_worker = outcome.has_value();
      if (!outcome) unprepared_.push(client, stream->place, stream);
      changed_ = true;
    }
    if (outcome) finish(stream, std::move(*outcome));
    lacks_.notify_one();
    report_.notify_one();
  }
}

bool Runtime::isQuiet() const {
  const MutexLock lock(mutex_);
  return open_.empty();
}

void Runtime::statusLoop() noexcept {
  nameThread("status");
  auto trimmed_at = Clock::now();
  while (true) {
    expireQueued();
    publishStatus();
    if (Clock::now() - trimmed_at >= kTrimPeriod && isQuiet()) {
      giveUnusedMemoryBack();
      trimmed_at = Clock::now();
    }
    MutexLock lock(mutex_);
    if (stopping_) return;
    // At most 20 reports a second, at least one; queued deadlines in time.
    report_.wait_for(lock, 50ms, [this]() HANDOVER_REQUIRES(mutex_) { return stopping_; });
    auto until = Clock::now() + 950ms;
    const auto sooner = [&until](const StreamPtr& stream) {
      if (stream->deadline_at) until = std::min(until, *stream->deadline_at);
    };
    queue_.forEach(sooner);
    unprepared_.forEach(sooner);
    report_.wait_until(lock, until,
                       [this]() HANDOVER_REQUIRES(mutex_) { return stopping_ || changed_; });
  }
}

}  // namespace handover
