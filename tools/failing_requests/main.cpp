// SPDX-License-Identifier: Apache-2.0
// failing_requests: how soon requests that cannot be done are told so, and why.
//
// Draws changes of a cell that mostly leave it without a plan (a robot moved off, the object or its
// goal moved, furniture pushed in the way, an object of another size) until so many requests have
// failed. What failed goes to an experiment file, whose verdicts dense_search checks.
#include "cells/cell_service.hpp"
#include "draw.hpp"
#include "plan_file/json_writer.hpp"
#include "settings/roots.hpp"

#include <handover/common/random.hpp>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <thread>

namespace handover {
namespace {

using client::Json;
using ctl::DrawId;
using Clock = std::chrono::steady_clock;

/// Notes when the failure was told.
class FailureClock : public PlanEventSink {
 public:
  void emit(PlanEventPayload payload) override {
    if (auto* scene = std::get_if<SceneSnapshot>(&payload)) snapshot = std::move(*scene);
    if (!told && std::holds_alternative<Failure>(payload)) told = seconds();
  }

  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

  std::optional<double> told;
  SceneSnapshot snapshot;

 private:
  Clock::time_point begin_ = Clock::now();
};

/// Changes of one cell.
class Draws {
 public:
  Draws(const SceneSnapshot& scene, const std::string& task, const PoseValue& X_WO_goal)
      : scene_(scene), task_(task), goal_(X_WO_goal) {}

  Json next(SeededRandom& random) const {
    switch (random.index(6)) {
      case 0:
        return movedRobot(random, 1.0);
      case 1:
        return movedRobot(random, 0.4);
      case 2:
        return shifted("objects." + scene_.object + ".pose.xyz", objectXyz(), random, 0.5, 0);
      case 3:
        return shifted("tasks." + task_ + ".goal", goal_.xyz, random, 0.5, 0.3);
      case 4:
        return pushedFurniture(random);
      default:
        return twice(random);
    }
  }

 private:
  using Xyz = std::array<double, 3>;

  static Json shifted(const std::string& path, const Xyz& xyz, SeededRandom& random, double aside,
                      double up) {
    Json value = {xyz[0] + random.uniform(-aside, aside), xyz[1] + random.uniform(-aside, aside),
                  xyz[2] + random.uniform(-up, up)};
    if (path.ends_with(".goal")) return {{path, {{"xyz", value}}}};
    return {{path, value}};
  }

  Xyz objectXyz() const {
    for (const ObjectSnapshot& object : scene_.objects) {
      if (object.name == scene_.object) return object.X_WO.xyz;
    }
    return {};
  }

  Json movedRobot(SeededRandom& random, double most) const {
    const auto which = random.index(static_cast<std::uint32_t>(scene_.robots.size()));
    const RobotSnapshot& robot = scene_.robots[which];
    return shifted("robots." + robot.name + ".base.xyz", robot.X_WB.xyz, random, most, 0);
  }

  Json pushedFurniture(SeededRandom& random) const {
    std::vector<const ObjectSnapshot*> furniture;
    for (const ObjectSnapshot& object : scene_.objects) {
      if (object.name != scene_.object && !object.attached_to) furniture.push_back(&object);
    }
    const auto which = random.index(static_cast<std::uint32_t>(furniture.size()));
    return shifted("objects." + furniture[which]->name + ".pose.xyz", furniture[which]->X_WO.xyz,
                   random, 0.8, 0.3);
  }

  Json twice(SeededRandom& random) const {
    Json both = movedRobot(random, 0.5);
    both.update(pushedFurniture(random));
    return both;
  }

  const SceneSnapshot& scene_;
  std::string task_;
  PoseValue goal_;
};

struct Tally {
  std::vector<double> told, fixed;
  std::map<std::string, std::vector<double>> by_reason;
  int exhaustive = 0, done = 0, refused = 0, with_fix = 0, nameless = 0;
};

/// A failure without a cause, or with one that is not said.
bool nameless(const Explanation& why) {
  return why.causes.empty() ||
         std::any_of(why.causes.begin(), why.causes.end(),
                     [](const auto& it) { return it.cause == Cause::kUnspecified; });
}

/// Found before any search: these are easily drawn, and soon told.
bool ofTheScene(FailureReason reason) {
  return reason == FailureReason::kStartInCollision || reason == FailureReason::kGoalInCollision ||
         reason == FailureReason::kStartUnsupported || reason == FailureReason::kGoalUnsupported;
}

/// One failed request as a record of an experiment file.
Json recordOf(int index, const Json& drawn, std::uint64_t seed, const Failed& failed, double told) {
  return {{"index", index},
          {"seed", seed},
          {"drawn", drawn},
          {"redrawn", 0},
          {"outcome", "failed"},
          {"reason", toString(failed.reason)},
          {"exhaustive", failed.explanation.exhaustive},
          {"text", failed.explanation.text},
          {"fix_text", failed.explanation.fix_text},
          {"failure_s", told}};
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print(const Tally& tally) {
  std::printf(
      "%zu failed, %d done, %d rejected; told after median %.0f ms, 95 %% %.0f, worst %.0f; "
      "with the fix sought worst %.0f; exhaustive %d; fixes %d; nameless causes %d\n",
      tally.told.size(), tally.done, tally.refused, 1e3 * quantile(tally.told, 0.5),
      1e3 * quantile(tally.told, 0.95), 1e3 * quantile(tally.told, 1),
      1e3 * quantile(tally.fixed, 1), tally.exhaustive, tally.with_fix, tally.nameless);
  for (const auto& [reason, times] : tally.by_reason) {
    std::printf("  %-22s %4zu  median %6.0f ms  worst %6.0f ms\n", reason.c_str(), times.size(),
                1e3 * quantile(times, 0.5), 1e3 * quantile(times, 1));
  }
}

/// How late [s] requests end that are cancelled, or whose deadline passes, at random moments.
std::vector<double> interrupt(CellService& service, PlanRequest request, const Draws& draws,
                              SeededRandom& random, int times) {
  std::vector<double> late;
  request.wants_fix = true;
  while (static_cast<int>(late.size()) < times) {
    request.overrides = ctl::overridesOf(draws.next(random));
    ++request.seed;
    const std::chrono::duration<double> moment(random.uniform(0, 0.4));
    const bool cancels = random.unit() < 0.5;
    const auto begin = Clock::now();
    const auto at = begin + std::chrono::duration_cast<Clock::duration>(moment);
    const Deadline deadline = cancels ? Deadline() : Deadline(at);
    FailureClock sink;
    {
      std::jthread canceller;
      if (cancels) {
        canceller = std::jthread([&] {
          std::this_thread::sleep_until(at);
          deadline.cancel();
        });
      }
      (void)service.planAlone(request, sink, deadline);
      const std::chrono::duration<double> over = Clock::now() - at;
      if (over.count() > 0) late.push_back(over.count());
    }
  }
  return late;
}

int run(int argc, char** argv) {
  CLI::App app("Draws requests that mostly fail, and times and lists the failures.",
               "failing_requests");
  std::string cell, root, output;
  int failures = 60, interrupted = 0;
  std::uint64_t seed = 1;
  bool fix = false, own = false;
  app.add_option("CELL", cell, "Cell of config/cells, or file")->required();
  app.add_option("--failures", failures, "How many failed requests to gather")
      ->capture_default_str();
  app.add_option("--seed", seed, "Of the draws")->capture_default_str();
  app.add_flag("--fix", fix, "Ask for the nearest fix too");
  app.add_option("--interrupt", interrupted,
                 "Instead: how late this many requests end that are cut at random moments");
  app.add_flag("--own", own, "The draws of the cell's experiments instead, so many");
  app.add_option("--root", root, "Where config/ and robots/ are");
  app.add_option("--output", output, "Experiment file of the failures, for dense_search");
  app.footer(
      "Example: failing_requests butler --output f.json && dense_search f.json\n"
      "Exit codes: 0 done, 1 unreadable input, 2 usage.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  CellService service(findRoot(root), {cell}, cacheFolder(""), {}, false);
  service.prepareAll(Deadline());
  const CellInfo served = service.served()->infos.front();
  PlanRequest request;
  request.client_id = "failing_requests";
  request.cell = served.name;
  request.mode = SearchMode::kFirst;
  request.wants_fix = fix;

  FailureClock nominal;
  (void)service.planAlone(request, nominal, Deadline());
  const std::string task = served.tasks.front();
  const Draws draws(nominal.snapshot, task, nominal.snapshot.goal.X_WO);
  SeededRandom random(SeededRandom::mix(seed));
  if (interrupted > 0) {
    const std::vector<double> late = interrupt(service, request, draws, random, interrupted);
    std::printf(
        "%zu requests cut by a deadline or a cancel ended late by: median %.1f ms, 95 %% "
        "%.1f, worst %.1f\n",
        late.size(), 1e3 * quantile(late, 0.5), 1e3 * quantile(late, 0.95),
        1e3 * quantile(late, 1));
    return 0;
  }
  Tally tally;
  int of_the_scene = 0;
  Json records = Json::array();
  for (int index = 0; static_cast<int>(tally.told.size()) < failures; ++index) {
    if (own && index == failures) break;
    const DrawId id{seed, static_cast<std::uint64_t>(index), 0};
    const Json drawn =
        own ? ctl::draw(served.variations, id, 1.0)
            : draws.next(random);  // of those found in the scene alone a quarter is kept
    request.overrides = ctl::overridesOf(drawn);
    request.seed = seed + static_cast<std::uint64_t>(index);
    FailureClock sink;
    const Outcome outcome = service.planAlone(request, sink, Deadline());
    if (std::holds_alternative<Done>(outcome)) ++tally.done;
    if (std::holds_alternative<Rejected>(outcome)) ++tally.refused;
    const auto* failed = std::get_if<Failed>(&outcome);
    if (failed == nullptr) continue;
    if (ofTheScene(failed->reason) && ++of_the_scene > failures / 4) continue;
    const double told = sink.told.value_or(sink.seconds());
    tally.told.push_back(told);
    tally.fixed.push_back(sink.seconds());
    tally.by_reason[toString(failed->reason)].push_back(told);
    tally.exhaustive += failed->explanation.exhaustive ? 1 : 0;
    tally.with_fix += failed->explanation.nearest_fix.empty() ? 0 : 1;
    tally.nameless += nameless(failed->explanation) ? 1 : 0;
    records.push_back(recordOf(index, drawn, request.seed, *failed, told));
  }
  print(tally);
  if (!output.empty()) {
    const Json file = {{"format", "handover-experiment/2"},
                       {"cell", request.cell},
                       {"seed", seed},
                       {"records", std::move(records)}};
    std::ofstream(output) << file.dump(1) << '\n';
  }
  return 0;
}

}  // namespace
}  // namespace handover

int main(int argc, char** argv) {
  try {
    return handover::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "failing_requests: %s\n", error.what());
    return 1;
  }
}
