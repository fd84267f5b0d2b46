// SPDX-License-Identifier: Apache-2.0
// handoverctl experiment: many requests, drawn from what a cell says varies.
#include "command.hpp"
#include "draw.hpp"
#include "experiment_file.hpp"
#include "experiment_page.hpp"
#include "failure_page.hpp"
#include "output_file.hpp"
#include "verify_program.hpp"
#include "view/page.hpp"

#include <handover/client/answer.hpp>
#include <handover/common/mutex.hpp>

#include <spdlog/fmt/fmt.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <thread>

namespace handover::ctl {
namespace {

namespace fs = std::filesystem;
using client::Client;
using client::Json;
using client::PlanHandle;

constexpr std::uint64_t kLattices = 100;  // runs whose crossed maps the page shows

/// Ends an experiment with an exit code of its own.
struct ExperimentFailure {
  int exit_code;
  std::string text;
};

std::string machineText() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string name;
  for (std::string line; name.empty() && std::getline(cpuinfo, line);) {
    if (line.rfind("model name", 0) == 0) name = line.substr(line.find(':') + 2);
  }
  if (utsname system{}; name.empty() && uname(&system) == 0) name = system.machine;
  return fmt::format("{}, {} cores", name, std::thread::hardware_concurrency());
}

/// A folder that is gone in the end, for plans that nobody asked to keep.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "handover-plans-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw ExperimentFailure{kExitConfiguration, "no " + name};
    path_ = name;
  }

  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// How many runs are answered, on standard error: a line that changes on a terminal, else one for
/// each tenth.
class Progress {
 public:
  explicit Progress(std::uint64_t runs) : runs_(runs) {}

  ~Progress() {
    if (terminal_ && answered_ > 0) std::cerr << std::endl;
  }

  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void add(const RunRecord& run) {
    ++answered_;
    solved_ += run.done();
    redrawn_ += run.redrawn;
    const bool tenth = answered_ * 10 / runs_ != (answered_ - 1) * 10 / runs_;
    if (!terminal_ && !tenth) return;
    std::cerr << (terminal_ ? "\r\033[K" : "") << answered_ << " of " << runs_ << " runs, "
              << solved_ << " solved";
    if (redrawn_ > 0) std::cerr << ", " << redrawn_ << " drawn again";
    std::cerr << (terminal_ ? "" : "\n") << std::flush;
  }

 private:
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  const std::uint64_t runs_;
  std::uint64_t answered_ = 0, solved_ = 0, redrawn_ = 0;
};

class Experiment {
 public:
  Experiment(const CommonOptions& common, const ExperimentOptions& options, Client& client)
      : common_(common),
        options_(options),
        client_(client),
        failures_(options.html),
        progress_(options.runs) {
    if (options.verify) verifier_.emplace();
    if (options.verify && options.plans.empty()) scratch_.emplace();
    if (!plansFolder().empty()) {
      std::error_code error;
      fs::create_directories(plansFolder(), error);
      if (error) {
        throw ExperimentFailure{kExitConfiguration, "cannot write to " + plansFolder().string()};
      }
    }
  }

  /// Asks for all runs. @throws ExperimentFailure, client::ClientError.
  ExperimentRecord run() {
    const CellInfo cell = awaitCell();
    variations_ = cell.variations;
    {
      std::vector<std::jthread> workers;
      const auto jobs = std::min(static_cast<std::uint64_t>(options_.jobs), options_.runs);
      for (std::uint64_t i = 0; i < jobs; ++i) workers.emplace_back([this] { work(); });
    }
    const MutexLock lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    if (stopped_) throw ExperimentFailure{kExitCancelled, "cancelled"};
    ExperimentRecord record;
    record.cell = options_.request.cell;
    record.seed = options_.request.seed;
    record.mode = options_.request.mode;
    record.search = options_.request.search;
    if (options_.request.objective != Objective::kUnspecified) {
      record.objective = options_.request.objective;
    }
    record.stretch = options_.stretch;
    record.machine = machineText();
    record.task = options_.request.task;
    if (record.task.empty() && !cell.tasks.empty()) record.task = cell.tasks.front();
    record.daemon_version = daemon_version_;
    for (auto& [index, run] : answered_) record.runs.push_back(std::move(run));
    return record;
  }

  /// Why the cell's ranges are unsound; empty: they are not. After run().
  std::string unsound() const {
    const MutexLock lock(mutex_);
    return unsound_;
  }

  /// What failed, where there is a report that links to it. After run().
  FailurePage failures() const {
    const MutexLock lock(mutex_);
    return failures_;
  }

  /// Cancels what is under way. From any thread.
  void stop() {
    {
      const MutexLock lock(mutex_);
      stopped_ = true;
      for (const auto& [index, handle] : open_) cancel(handle);
    }
    changed_.notify_all();
    client_.interrupt();
  }

 private:
  fs::path plansFolder() const { return scratch_ ? scratch_->path() : fs::path(options_.plans); }

  /// The cell as its daemon announces it, once that is ready: no run shall wait for its maps.
  CellInfo awaitCell() {
    bool told = false;
    while (true) {
      const CellInfo* found = nullptr;
      const std::vector<DaemonStatus> daemons = client_.daemons();
      for (const DaemonStatus& daemon : daemons) {
        for (const CellInfo& cell : daemon.cells) {
          if (cell.name != options_.request.cell) continue;
          if (daemon.state == DaemonState::kReady) {
            daemon_version_ = daemon.version;
            return checked(cell);
          }
          found = &cell;
        }
      }
      if (found == nullptr) {
        throw ExperimentFailure{kExitRejected,
                                "no daemon serves a cell named '" + options_.request.cell + "'"};
      }
      if (!told) std::cerr << "the daemon makes maps and grasp sets first" << std::endl;
      told = true;
      MutexLock lock(mutex_);
      changed_.wait_for(lock, std::chrono::milliseconds(200),
                        [this]() HANDOVER_REQUIRES(mutex_) { return stopped_; });
    }
  }

  CellInfo checked(const CellInfo& cell) const {
    const std::string& task = options_.request.task;
    if (!task.empty() &&
        std::find(cell.tasks.begin(), cell.tasks.end(), task) == cell.tasks.end()) {
      throw ExperimentFailure{kExitRejected, "the cell has no task '" + task + "'"};
    }
    return cell;
  }

  void work() noexcept {
    try {
      while (const auto index = next()) {
        if (auto record = answer(*index)) keep(std::move(*record));
      }
    } catch (...) {
      {
        const MutexLock lock(mutex_);
        if (!failure_ && !stopped_) failure_ = std::current_exception();
      }
      stop();
    }
  }

  std::optional<std::uint64_t> next() {
    const MutexLock lock(mutex_);
    if (stopped_ || !unsound_.empty() || next_ == options_.runs) return std::nullopt;
    return next_++;
  }

  /// Draws a run until its start scene is free and has it planned, or until too many are drawn
  /// again; nullopt when it was stopped.
  std::optional<RunRecord> answer(std::uint64_t index) {
    RunRecord record;
    record.index = index;
    record.seed = options_.request.seed + index;
    while (true) {
      record.drawn =
          draw(variations_, {options_.request.seed, index, record.redrawn}, options_.stretch);
      const auto outcome = ask(record);
      if (!outcome) return std::nullopt;
      const std::vector<NamePair> touching = touchingAtStart(*outcome, record.object);
      if (touching.empty()) return record;
      ++record.redrawn;
      record.touched.insert(record.touched.end(), touching.begin(), touching.end());
      if (countRedrawn(touching)) return record;
    }
  }

  /// The pairs without the moved object that touch in the start scene: nothing to plan in.
  static std::vector<NamePair> touchingAtStart(const Outcome& outcome, const std::string& object) {
    std::vector<NamePair> pairs;
    const auto* failed = std::get_if<Failed>(&outcome);
    if (failed == nullptr || failed->reason != FailureReason::kStartInCollision) return pairs;
    for (const CauseCount& cause : failed->explanation.causes) {
      const auto& [first, second] = cause.pair;
      if (first.empty() || second.empty() || first == object || second == object) continue;
      pairs.push_back(cause.pair);
    }
    return pairs;
  }

  /// One request; fills in what the answer says.
  std::optional<Outcome> ask(RunRecord& record) {
    PlanRequest request = options_.request;
    request.seed = record.seed;
    request.overrides = overridesOf(record.drawn);
    request.wants_fix = false;

    struct Gathered {  // shared with the callback, which may outlive this call if it throws
      Funnel funnel;
      client::Answer answer;
    };

    const auto gathered = std::make_shared<Gathered>();
    const PlanHandle handle = client_.plan(request, [gathered](const PlanEvent& event) {
      gathered->funnel.add(event);
      gathered->answer.add(event);
    });
    open(record.index, handle);
    const Outcome outcome = handle.wait();
    if (close(record.index)) return std::nullopt;
    record.planning_time_s = handle.answerTime().count();
    const client::Answer& answer = gathered->answer;
    measure(handle, answer, record);
    record.counts = gathered->funnel.counts();
    if (!options_.html.empty()) keepPlaces(gathered->funnel, record);
    describe(outcome, record);
    if (record.done() && !answer.hasPlan()) {
      throw ExperimentFailure{kExitInternal, "incomplete answer from the daemon"};
    }
    const bool to_be_shown = record.outcome == "failed" && answer.hasScene();
    record.failure_text = to_be_shown && !options_.html.empty() ? answer.text() : "";
    if (!plansFolder().empty()) keepPlan(answer, record);
    record.object = gathered->funnel.object();
    return outcome;
  }

  static void measure(const PlanHandle& handle, const client::Answer& answer, RunRecord& record) {
    record.first_plan_s.reset();
    record.failure_s.reset();
    if (const auto first = handle.firstPlanTime()) record.first_plan_s = first->count();
    if (const auto failure = handle.failureTime()) record.failure_s = failure->count();
    record.first_cost = answer.firstCost();
    if (const Solution* solution = answer.solution()) {
      record.cost = solution->cost;
      record.quality = solution->quality;
    }
  }

  static void keepPlaces(const Funnel& funnel, RunRecord& record) {
    if (const Solution* chosen = funnel.chosen()) {
      for (std::size_t i = 0; i < chosen->X_WO_handovers.size(); ++i) {
        const PoseValue& X_WO = chosen->X_WO_handovers[i];
        const Pose X_WT = toPose(X_WO) * toPose(chosen->holders[i + 1].X_OT);
        record.handovers.push_back({X_WO.xyz, toValue(X_WT).xyz});
      }
    }
    if (record.index < kLattices) record.lattice = funnel.lattice();
  }

  static void describe(const Outcome& outcome, RunRecord& record) {
    record.outcome = "done";
    if (const auto* failed = std::get_if<Failed>(&outcome)) {
      record.outcome = "failed";
      record.reason = toString(failed->reason);
      record.explanation = failed->explanation.text;
    } else if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
      record.outcome = "rejected";
      record.reason = toString(rejected->reason);
      for (const Fault& fault : rejected->faults) {
        if (!record.explanation.empty()) record.explanation += "; ";
        record.explanation += fault.field + ": " + fault.message;
      }
    } else if (std::holds_alternative<Cancelled>(outcome)) {
      record.outcome = "cancelled";
    }
  }

  /// Writes the plan and has it verified, or writes the failure. A run that is neither leaves no
  /// file of its name, not even an older one.
  void keepPlan(const client::Answer& answer, RunRecord& record) {
    const fs::path file = plansFolder() / fmt::format("{:03}.json", record.index);
    if (!answer.writable() || (scratch_ && !record.done())) {
      std::error_code ignored;
      fs::remove(file, ignored);
      return;
    }
    OutputFile output(file);
    if (!output.writable() || !output.commit(answer.text())) {
      throw ExperimentFailure{kExitConfiguration, "cannot write " + file.string()};
    }
    if (record.done()) verify(file, record);
  }

  void verify(const fs::path& file, RunRecord& record) {
    try {
      if (verifier_) record.violations = verifier_->violations(file, options_.root);
    } catch (const UnreadablePlan& fault) {
      throw ExperimentFailure{kExitUsage, fmt::format("handover-verify cannot read plan {:03}: {}",
                                                      record.index, fault.what())};
    }
    if (scratch_) fs::remove(file);
  }

  void open(std::uint64_t index, const PlanHandle& handle) {
    const MutexLock lock(mutex_);
    open_.insert_or_assign(index, handle);
    if (stopped_) cancel(handle);
  }

  /// What cannot be cancelled ends with the client.
  static void cancel(const PlanHandle& handle) {
    try {
      handle.cancel();
    } catch (const client::ClientError&) {
    }
  }

  /// True when the run was stopped.
  bool close(std::uint64_t index) {
    const MutexLock lock(mutex_);
    open_.erase(index);
    return stopped_;
  }

  void keep(RunRecord record) {
    const MutexLock lock(mutex_);
    progress_.add(record);
    if (common_.json) {
      Json line = {{"type", "run"}};
      line.update(toJson(record));
      std::cout << client::compact(line) << std::endl;
    }
    if (!record.failure_text.empty()) {
      failures_.add(record.index, std::move(record.failure_text));
    }
    answered_.emplace(record.index, std::move(record));
  }

  /// Ranges that often lead to start scenes that touch are unsound; true when they are.
  bool countRedrawn(const std::vector<NamePair>& touching) {
    const MutexLock lock(mutex_);
    ++redrawn_;
    for (const auto& [first, second] : touching) ++redrawn_for_[first + " - " + second];
    if (redrawn_ * 10 <= options_.runs) return false;
    unsound_ = fmt::format("{} of {} drawn start scenes are in collision (limit 10 % of {} runs):",
                           redrawn_, redrawn_ + answered_.size(), options_.runs);
    for (const auto& [what, count] : redrawn_for_)
      unsound_ += fmt::format(" {} ({} x)", what, count);
    return true;
  }

  const CommonOptions& common_;
  const ExperimentOptions& options_;
  Client& client_;
  std::optional<VerifyProgram> verifier_;
  std::optional<ScratchFolder> scratch_;
  std::vector<Variation> variations_;
  std::string daemon_version_;

  mutable Mutex mutex_;
  Condition changed_;
  FailurePage failures_ HANDOVER_GUARDED_BY(mutex_);
  Progress progress_ HANDOVER_GUARDED_BY(mutex_);
  std::uint64_t next_ HANDOVER_GUARDED_BY(mutex_) = 0;
  std::uint64_t redrawn_ HANDOVER_GUARDED_BY(mutex_) = 0;
  std::map<std::string, int> redrawn_for_ HANDOVER_GUARDED_BY(mutex_);
  std::string unsound_ HANDOVER_GUARDED_BY(mutex_);
  std::map<std::uint64_t, PlanHandle> open_ HANDOVER_GUARDED_BY(mutex_);
  std::map<std::uint64_t, RunRecord> answered_ HANDOVER_GUARDED_BY(mutex_);
  std::exception_ptr failure_ HANDOVER_GUARDED_BY(mutex_);
  bool stopped_ HANDOVER_GUARDED_BY(mutex_) = false;
};

/// What the records mean for the process.
int exitCodeOf(const CommonOptions& common, const ExperimentRecord& record) {
  const auto count = [&record](auto condition) {
    return static_cast<std::size_t>(
        std::count_if(record.runs.begin(), record.runs.end(), condition));
  };
  const auto invalid =
      count([](const RunRecord& run) { return run.violations && !run.violations->empty(); });
  const auto cancelled = count([](const RunRecord& run) { return run.outcome == "cancelled"; });
  const auto rejected = count([](const RunRecord& run) { return run.outcome == "rejected"; });
  if (invalid > 0) return fail(common, kExitInternal, fmt::format("{} invalid plans", invalid));
  if (cancelled > 0)
    return fail(common, kExitCancelled, fmt::format("{} runs cancelled", cancelled));
  if (rejected == record.runs.size()) return fail(common, kExitRejected, "every run was rejected");
  return kExitDone;
}

/// The page's own, and the links to the page of failures where that is written.
PageExtras extrasOf(const ExperimentRecord& record, const FailurePage* failures) {
  PageExtras extras{record.task, record.daemon_version, {}};
  for (const RunRecord& run : record.runs) {
    const std::string page = failures == nullptr ? "" : failures->linkTo(run.index);
    extras.runs.push_back({run.lattice, run.handovers, page});
  }
  return extras;
}

/// False where a page cannot be written. Failures that cannot be drawn, as the robots' files are
/// not here, keep their words in the report.
bool writePages(const ExperimentOptions& options, const ExperimentRecord& record,
                const FailurePage& failures, const Json& file, OutputFile& html) {
  bool shown = true;
  try {
    if (!failures.write(options.root)) return false;
  } catch (const client::PlanFileError& fault) {
    std::cerr << "handoverctl: not written: " << failures.path().string() << ": " << fault.what()
              << std::endl;
    shown = false;
  }
  return html.commit(experimentPage(file, extrasOf(record, shown ? &failures : nullptr)));
}

}  // namespace

int runExperiment(const CommonOptions& common, const ExperimentOptions& options) {
  if (!options.html.empty() && !view::hasPages()) {
    return fail(common, kExitConfiguration, view::kNoPages);
  }
  // Opened before the daemon is asked: what cannot be kept need not be planned.
  std::optional<OutputFile> output, html;
  for (const auto& [path, file] :
       {std::pair(&options.output, &output), std::pair(&options.html, &html)}) {
    if (path->empty()) continue;
    if (!file->emplace(*path).writable()) {
      return fail(common, kExitConfiguration, "cannot write " + *path);
    }
  }
  return withClient(common, [&](Client& client) -> int {
    try {
      ExperimentRecord record;
      std::string unsound;
      std::optional<FailurePage> failures;
      {
        Experiment experiment(common, options, client);
        const SignalWatch signals([&experiment] { experiment.stop(); }, kExitCancelled);
        record = experiment.run();
        unsound = experiment.unsound();
        failures = experiment.failures();
      }
      printTable(people(common), record);
      if (common.json) {
        Json line = {{"type", "summary"}};
        line.update(summaryOf(record));
        std::cout << client::compact(line) << std::endl;
      }
      const Json file = toJson(record);
      if (output && !output->commit(client::pretty(file) + "\n")) {
        return fail(common, kExitConfiguration, "cannot write " + options.output);
      }
      if (html && !writePages(options, record, *failures, file, *html)) {
        return fail(common, kExitConfiguration, "cannot write " + options.html);
      }
      if (!unsound.empty()) return fail(common, kExitConfiguration, unsound);
      return exitCodeOf(common, record);
    } catch (const ExperimentFailure& failure) {
      return fail(common, failure.exit_code, failure.text);
    }
  });
}

}  // namespace handover::ctl
