// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include "json_writer.hpp"
#include "report.hpp"
#include "signals.hpp"
#include "verify/state_obj.hpp"
#include "verify/unreadable.hpp"

#include <handover/client/client.hpp>
#include <handover/client/plan_file.hpp>

#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>

namespace handover::ctl {
namespace {

using client::Client;
using client::ClientError;
using client::Json;

std::ostream& people(const CommonOptions& common) { return common.json ? std::cerr : std::cout; }

int fail(const CommonOptions& common, int code, const std::string& text) {
  std::cerr << "handoverctl: " << text << std::endl;
  if (common.json) {
    std::cout << client::compact(Json{{"type", "error"}, {"exit_code", code}, {"text", text}})
              << std::endl;
  }
  return code;
}

int exitCodeOf(ClientError::Code code) {
  switch (code) {
    case ClientError::Code::kNoDaemon:
    case ClientError::Code::kDaemonLost:
      return kExitNoDaemon;
    case ClientError::Code::kInterrupted:
      return kExitCancelled;
    case ClientError::Code::kBadStream:
      return kExitInternal;
    case ClientError::Code::kDds:
      return kExitDds;
  }
  return kExitInternal;
}

/// Runs a command with a client; its errors become exit codes.
template <typename Command>
int withClient(const CommonOptions& common, Command command) {
  SignalWatch::blockSignals();
  try {
    Client client({.domain = common.domain, .client_id = {}, .wait = common.wait});
    return command(client);
  } catch (const ClientError& error) {
    return fail(common, exitCodeOf(error.code()), error.what());
  } catch (const std::exception& error) {
    return fail(common, kExitInternal, error.what());
  }
}

/// A file that is there, in whole, or not at all: written beside its place and renamed.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path) : path_(path) {
    std::error_code none;
    special_ = std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none);
    target_ = special_ ? path : path + ".part";
    file_.open(target_, std::ios::binary);
  }

  ~OutputFile() {
    std::error_code ignored;
    if (!special_ && !committed_) std::filesystem::remove(target_, ignored);
  }

  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  bool writable() const { return file_.is_open(); }

  bool commit(const std::string& text) {
    file_ << text;
    file_.close();
    if (!file_) return false;
    std::error_code error;
    if (!special_) std::filesystem::rename(target_, path_, error);
    committed_ = !error;
    return committed_;
  }

 private:
  std::filesystem::path path_, target_;
  std::ofstream file_;
  bool special_ = false, committed_ = false;
};

Json cellJson(const CellInfo& cell) {
  return {{"name", cell.name}, {"tasks", cell.tasks}, {"scene_revision", cell.revision}};
}

Json statusJson(const DaemonStatus& status) {
  Json cells = Json::array();
  for (const CellInfo& cell : status.cells) cells.push_back(cellJson(cell));
  const OutcomeCounters& n = status.counters;
  return {{"id", RequestId{status.id}.hex()},
          {"version", status.version},
          {"state", toString(status.state)},
          {"cells", std::move(cells)},
          {"queued", status.queued},
          {"running", status.running},
          {"counters",
           {{"accepted", n.accepted},
            {"done", n.done},
            {"failed", n.failed},
            {"cancelled", n.cancelled},
            {"rejected", n.rejected}}}};
}

/// The stages of watched requests, as they come from the client's thread.
class WatchedOutcome {
 public:
  void set(const Outcome& outcome) {
    const std::lock_guard lock(mutex_);
    if (!outcome_) outcome_ = outcome;
    changed_.notify_all();
  }

  void touch() {
    const std::lock_guard lock(mutex_);
    seen_ = true;
    changed_.notify_all();
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

  /// False if no stage came within `most`.
  bool waitForFirst(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, most, [this] { return seen_ || stopped_; });
  }

  /// The outcome; nullopt after stop(). @throws ClientError (kDaemonLost) when all daemons went
  /// away and none came back within `patience`.
  std::optional<Outcome> wait(const Client& client, std::chrono::milliseconds patience) {
    using Clock = std::chrono::steady_clock;
    auto last_seen = Clock::now();
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(100),
                              [this] { return outcome_ || stopped_; })) {
      if (client.daemonThere()) {
        last_seen = Clock::now();
      } else if (Clock::now() - last_seen > patience) {
        throw ClientError(ClientError::Code::kDaemonLost,
                          "the daemon went away and did not come back");
      }
    }
    return outcome_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Outcome> outcome_;
  bool seen_ = false, stopped_ = false;
};

}  // namespace

int exitCodeOf(const Outcome& outcome) {
  if (std::holds_alternative<Done>(outcome)) return kExitDone;
  if (std::holds_alternative<Cancelled>(outcome)) return kExitCancelled;
  if (std::holds_alternative<Rejected>(outcome)) return kExitRejected;
  switch (std::get<Failed>(outcome).reason) {
    case FailureReason::kDeadline:
      return kExitCancelled;
    case FailureReason::kInternal:
    case FailureReason::kUnspecified:
      return kExitInternal;
    case FailureReason::kStartUnreachable:
    case FailureReason::kGoalUnreachable:
    case FailureReason::kNoGraspAtStart:
    case FailureReason::kNoGraspAtGoal:
    case FailureReason::kNoCommonWorkspace:
    case FailureReason::kNoHandoverPose:
    case FailureReason::kNoPath:
    case FailureReason::kStartInCollision:
    case FailureReason::kGoalInCollision:
      return kExitNoPlan;
  }
  return kExitInternal;
}

int runStatus(const CommonOptions& common) {
  return withClient(common, [&](Client& client) {
    const SignalWatch signals([&client] { client.interrupt(); }, kExitCancelled);
    for (const DaemonStatus& status : client.daemons()) {
      printStatus(people(common), status);
      if (common.json) std::cout << client::compact(statusJson(status)) << std::endl;
    }
    return kExitDone;
  });
}

int runCells(const CommonOptions& common) {
  return withClient(common, [&](Client& client) {
    const SignalWatch signals([&client] { client.interrupt(); }, kExitCancelled);
    for (const DaemonStatus& status : client.daemons()) {
      for (const CellInfo& cell : status.cells) {
        people(common) << cell.name << ":";
        for (const auto& task : cell.tasks) people(common) << ' ' << task;
        people(common) << std::endl;
        if (common.json) std::cout << client::compact(cellJson(cell)) << std::endl;
      }
    }
    return kExitDone;
  });
}

int runPlan(const CommonOptions& common, const PlanOptions& options) {
  // Opened before the daemon is asked: a plan that cannot be kept need not be made.
  std::optional<OutputFile> output;
  if (!options.output.empty()) output.emplace(options.output);
  std::vector<std::unique_ptr<OutputFile>> dumps;
  for (const StateDump& dump : options.dumps)
    dumps.push_back(std::make_unique<OutputFile>(dump.file));
  if (output && !output->writable())
    return fail(common, kExitConfiguration, "cannot write " + options.output);
  for (std::size_t i = 0; i < dumps.size(); ++i) {
    if (!dumps[i]->writable())
      return fail(common, kExitConfiguration, "cannot write " + options.dumps[i].file);
  }
  return withClient(common, [&](Client& client) -> int {
    std::mutex mutex;  // guards handle, stopped
    std::optional<client::PlanHandle> handle;
    bool stopped = false;
    const SignalWatch signals(
        [&] {
          const std::lock_guard lock(mutex);
          stopped = true;
          if (handle) {
            handle->cancel();
          } else {
            client.interrupt();
          }
        },
        kExitCancelled);

    // Shared with the callback, which may still run when plan() throws.
    const auto report = std::make_shared<Report>(people(common));
    const auto sent = client.plan(options.request, [&common, report](const PlanStage& stage) {
      report->add(stage);
      if (common.json) std::cout << client::jsonLine(stage) << std::endl;
    });
    {
      const std::lock_guard lock(mutex);
      handle = sent;
      if (stopped) sent.cancel();
    }
    const Outcome outcome = sent.wait();
    if (!std::holds_alternative<Done>(outcome)) return exitCodeOf(outcome);
    if (!report->plan().complete())
      return fail(common, kExitInternal, "the daemon sent no whole plan");
    if (output && !output->commit(report->plan().text())) {
      return fail(common, kExitConfiguration, "cannot write " + options.output);
    }
    for (std::size_t i = 0; i < dumps.size(); ++i) {
      const StateDump& dump = options.dumps[i];
      try {
        if (!dumps[i]->commit(verify::stateObj(report->plan().text(), options.root, dump.kind))) {
          return fail(common, kExitConfiguration, "cannot write " + dump.file);
        }
      } catch (const verify::Unreadable& fault) {
        return fail(common, kExitUsage, "state at " + dump.kind + ": " + fault.what());
      }
    }
    return kExitDone;
  });
}

int runWatch(const CommonOptions& common, const std::optional<RequestId>& id) {
  return withClient(common, [&](Client& client) -> int {
    const auto watched = std::make_shared<WatchedOutcome>();
    const SignalWatch signals(
        [&client, watched] {
          client.interrupt();
          watched->stop();
        },
        kExitCancelled);
    std::map<RequestId, Report> reports;
    client.watch([&common, watched, id, reports](const PlanStage& stage) mutable {
      if (id && stage.request_id != *id) return;
      watched->touch();
      if (!id && stage.sequence == 0) {
        people(common) << "request " << stage.request_id.hex() << "\n";
      }
      reports.try_emplace(stage.request_id, people(common)).first->second.add(stage);
      if (common.json) std::cout << client::jsonLine(stage) << std::endl;
      const auto* outcome = std::get_if<Outcome>(&stage.payload);
      if (outcome == nullptr) return;
      reports.erase(stage.request_id);
      if (id) watched->set(*outcome);
    });
    if (id && !watched->waitForFirst(common.wait)) {
      return fail(common, kExitRejected, "no daemon knows the request " + id->hex());
    }
    const auto outcome = watched->wait(client, common.wait);
    if (!outcome) return kExitDone;  // stopped by a signal, as one stops watching
    return exitCodeOf(*outcome);
  });
}

int runCancel(const CommonOptions& common, const RequestId& id) {
  return withClient(common, [&](Client& client) -> int {
    const auto watched = std::make_shared<WatchedOutcome>();
    const SignalWatch signals(
        [&client, watched] {
          client.interrupt();
          watched->stop();
        },
        kExitCancelled);
    client.watch([&common, watched, id](const PlanStage& stage) {
      if (stage.request_id != id) return;
      watched->touch();
      if (const auto* outcome = std::get_if<Outcome>(&stage.payload)) {
        if (common.json) std::cout << client::jsonLine(stage) << std::endl;
        watched->set(*outcome);
      }
    });
    client.cancel(id);
    if (!watched->waitForFirst(common.wait)) {
      return fail(common, kExitRejected, "no daemon knows the request " + id.hex());
    }
    const auto outcome = watched->wait(client, common.wait);
    if (!outcome) return kExitCancelled;
    const bool cancelled = std::holds_alternative<Cancelled>(*outcome);
    people(common) << (cancelled ? "cancelled " : "had already ended: ") << id.hex() << std::endl;
    return kExitDone;
  });
}

}  // namespace handover::ctl
