// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"

#include "command.hpp"
#include "output_file.hpp"
#include "plan_file/json_writer.hpp"
#include "report.hpp"
#include "signals.hpp"
#include "state_obj.hpp"
#include "view/page.hpp"
#include "view/view.hpp"

#include <handover/client/answer.hpp>
#include <handover/client/client.hpp>
#include <handover/client/plan_file.hpp>
#include <handover/common/mutex.hpp>
#include <handover/common/printable.hpp>

#include <deque>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

namespace handover::ctl {
namespace {

using client::Client;
using client::ClientError;
using client::Json;

Json cellJson(const CellInfo& cell) {
  Json vary = Json::object();
  for (const Variation& variation : cell.variations) {
    Json& entry = vary[variation.path];
    if (variation.choices.empty()) {
      entry["range"] = {variation.from, variation.to};
    } else {
      entry["choices"] = variation.choices;
    }
    if (variation.facing) entry["facing"] = *variation.facing;
  }
  return {{"name", cell.name},
          {"tasks", cell.tasks},
          {"scene_revision", cell.revision},
          {"scene_hash", cell.scene_hash},
          {"role", toString(cell.role)},
          {"epoch", cell.epoch},
          {"vary", std::move(vary)}};
}

Json statusJson(const DaemonStatus& status) {
  Json cells = Json::array();
  for (const CellInfo& cell : status.cells) cells.push_back(cellJson(cell));
  const OutcomeCounters& n = status.counters;
  Json times = nullptr;
  if (const auto& t = status.answer_times) times = {{"median", t->median_ms}, {"p95", t->p95_ms}};
  return {{"id", RequestId{status.id}.hex()},
          {"version", status.version},
          {"state", toString(status.state)},
          {"cells", std::move(cells)},
          {"queued", status.queued},
          {"running", status.running},
          {"clients", status.clients},
          {"refused", status.refused},
          {"memory_bytes", status.memory_bytes},
          {"dropped_packets", status.dropped_packets},
          {"uptime_s", status.uptime_s},
          {"answer_ms", std::move(times)},
          {"kept_requests", status.kept_requests},
          {"counters",
           {{"accepted", n.accepted},
            {"done", n.done},
            {"failed", n.failed},
            {"cancelled", n.cancelled},
            {"rejected", n.rejected}}}};
}

/// The events of watched requests, as they come from the client's thread.
class WatchedOutcome {
 public:
  void set(const Outcome& outcome) {
    const MutexLock lock(mutex_);
    if (!outcome_) outcome_ = outcome;
    changed_.notify_all();
  }

  void touch() {
    const MutexLock lock(mutex_);
    seen_ = true;
    changed_.notify_all();
  }

  void stop() {
    const MutexLock lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

  /// False if no event came within `most`.
  bool waitForFirst(std::chrono::milliseconds most) {
    MutexLock lock(mutex_);
    return changed_.wait_for(lock, most,
                             [this]() HANDOVER_REQUIRES(mutex_) { return seen_ || stopped_; });
  }

  /// The outcome; nullopt after stop(). @throws ClientError (kDaemonLost) when all daemons went
  /// away and none came back within `patience`.
  std::optional<Outcome> wait(const Client& client, std::chrono::milliseconds patience) {
    using Clock = std::chrono::steady_clock;
    auto last_seen = Clock::now();
    MutexLock lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(100),
                              [this]()
                                  HANDOVER_REQUIRES(mutex_) { return outcome_ || stopped_; })) {
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
  Mutex mutex_;
  Condition changed_;
  std::optional<Outcome> outcome_ HANDOVER_GUARDED_BY(mutex_);
  bool seen_ HANDOVER_GUARDED_BY(mutex_) = false;
  bool stopped_ HANDOVER_GUARDED_BY(mutex_) = false;
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
    case FailureReason::kNoGrasp:
    case FailureReason::kNoGraspAtStart:
    case FailureReason::kNoGraspAtGoal:
    case FailureReason::kNoCommonWorkspace:
    case FailureReason::kNoHandoverPose:
    case FailureReason::kNoPath:
    case FailureReason::kStartInCollision:
    case FailureReason::kGoalInCollision:
    case FailureReason::kStartUnsupported:
    case FailureReason::kGoalUnsupported:
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
        people(common) << printable(cell.name) << ":";
        for (const auto& task : cell.tasks) people(common) << ' ' << printable(task);
        people(common) << std::endl;
        if (common.json) std::cout << client::compact(cellJson(cell)) << std::endl;
      }
    }
    return kExitDone;
  });
}

namespace {

/// A file that is made from a plan file's text.
struct Product {
  std::string file;
  bool of_failures;  ///< made of a failed request too
  std::function<std::string(const std::string& plan_text)> make;
};

std::vector<Product> productsOf(const PlanOptions& options) {
  std::vector<Product> products;
  if (!options.output.empty()) {
    products.push_back({options.output, true, [](const std::string& text) { return text; }});
  }
  for (const StateDump& dump : options.dumps) {
    products.push_back({dump.file, false, [&options, &dump](const std::string& text) {
                          return stateObj(text, options.root, dump.kind);
                        }});
  }
  if (!options.html.empty()) {
    products.push_back({options.html, true, [&options](const std::string& text) {
                          return view::planPage(text, options.root);
                        }});
  }
  return products;
}

/// Writes what can be made of the answer; kExitDone, or why not all of it is written.
int writeProducts(const CommonOptions& common, const client::Answer& answer,
                  const std::vector<Product>& products, std::deque<OutputFile>& files) {
  const std::string text = answer.text();
  int code = kExitDone;
  for (std::size_t i = 0; i < products.size(); ++i) {
    if (!answer.hasPlan() && !products[i].of_failures) continue;
    try {
      if (!files[i].commit(products[i].make(text))) {
        code = fail(common, kExitConfiguration, "cannot write " + products[i].file);
      }
    } catch (const client::PlanFileError& fault) {
      const std::string what = products[i].file + ": " + fault.what();
      // Of a failure before its scene was known there is nothing to draw: the reason counts.
      if (answer.hasPlan()) {
        code = fail(common, kExitUsage, what);
      } else {
        std::cerr << "handoverctl: not written: " << what << std::endl;
      }
    }
  }
  return code;
}

}  // namespace

int runPlan(const CommonOptions& common, const PlanOptions& options) {
  if (!options.html.empty() && !view::hasPages()) {
    return fail(common, kExitConfiguration, view::kNoPages);
  }
  // Opened before the daemon is asked: a plan that cannot be kept need not be made.
  const std::vector<Product> products = productsOf(options);
  std::deque<OutputFile> files;
  for (const Product& product : products) {
    if (!files.emplace_back(product.file).writable()) {
      return fail(common, kExitConfiguration, "cannot write " + product.file);
    }
  }
  return withClient(common, [&](Client& client) -> int {
    Mutex mutex;  // guards handle, stopped
    std::optional<client::PlanHandle> handle;
    bool stopped = false;
    const SignalWatch signals(
        [&] {
          const MutexLock lock(mutex);
          stopped = true;
          if (handle) {
            handle->cancel();
          } else {
            client.interrupt();
          }
        },
        kExitCancelled);

    // Shared with the callbacks, which may still run when plan() throws.
    const auto report = std::make_shared<Report>(people(common));
    const auto sent = client.plan(
        options.request,
        [&common, report](const PlanEvent& event) {
          report->add(event);
          if (common.json) std::cout << client::jsonLine(event) << std::endl;
        },
        [&common] {
          if (common.json) std::cout << client::compact(Json{{"type", "restart"}}) << std::endl;
        });
    {
      const MutexLock lock(mutex);
      handle = sent;
      if (stopped) sent.cancel();
    }
    const Outcome outcome = sent.wait();
    const client::Answer& answer = report->answer();
    if (std::holds_alternative<Done>(outcome) && !answer.hasPlan()) {
      return fail(common, kExitInternal, "incomplete answer from the daemon");
    }
    const int written =
        answer.writable() ? writeProducts(common, answer, products, files) : kExitDone;
    return written == kExitDone ? exitCodeOf(outcome) : written;
  });
}

int runView(const CommonOptions& common, const ViewOptions& options) {
  OutputFile output(options.output);
  if (!output.writable()) {
    return fail(common, kExitConfiguration, "cannot write " + options.output);
  }
  if (view::isPage(options.output) && !view::hasPages()) {
    return fail(common, kExitConfiguration, view::kNoPages);
  }
  std::string text;
  try {
    text = client::readPlanText(options.plan);
  } catch (const client::PlanFileError& fault) {
    return fail(common, kExitUsage, fault.what());
  }
  try {
    if (!output.commit(view::planView(text, options.output, options.root))) {
      return fail(common, kExitConfiguration, "cannot write " + options.output);
    }
  } catch (const client::PlanFileError& fault) {
    return fail(common, kExitUsage, options.plan + ": " + fault.what());
  }
  return kExitDone;
}

namespace {

/// An id that is wrong, not a request that is rejected.
int noSuchRequest(const CommonOptions& common, const RequestId& id) {
  return fail(common, kExitUsage, "no such request: no daemon knows " + id.hex());
}

}  // namespace

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
    client.watch([&common, watched, id, reports](const PlanEvent& event) mutable {
      if (id && event.request_id != *id) return;
      watched->touch();
      if (!id && event.sequence == 0) {
        people(common) << "request " << event.request_id.hex() << "\n";
      }
      reports.try_emplace(event.request_id, people(common)).first->second.add(event);
      if (common.json) std::cout << client::jsonLine(event) << std::endl;
      if (!std::cout) watched->stop();  // nobody reads it any more
      const auto* outcome = std::get_if<Outcome>(&event.payload);
      if (outcome == nullptr) return;
      reports.erase(event.request_id);
      if (id) watched->set(*outcome);
    });
    if (id && !watched->waitForFirst(common.wait)) {
      return noSuchRequest(common, *id);
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
    client.watch([&common, watched, id](const PlanEvent& event) {
      if (event.request_id != id) return;
      watched->touch();
      if (const auto* outcome = std::get_if<Outcome>(&event.payload)) {
        if (common.json) std::cout << client::jsonLine(event) << std::endl;
        watched->set(*outcome);
      }
    });
    client.cancel(id);
    if (!watched->waitForFirst(common.wait)) {
      return noSuchRequest(common, id);
    }
    const auto outcome = watched->wait(client, common.wait);
    if (!outcome) return kExitCancelled;
    const bool cancelled = std::holds_alternative<Cancelled>(*outcome);
    people(common) << (cancelled ? "cancelled " : "had already ended: ") << id.hex() << std::endl;
    return kExitDone;
  });
}

}  // namespace handover::ctl
