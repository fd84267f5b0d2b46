// SPDX-License-Identifier: Apache-2.0
// dense_search: are the failures of an experiment infeasible, or gaps in the planner's search?
#include "cells/cell_service.hpp"
#include "dense_search.hpp"
#include "draw.hpp"
#include "settings/roots.hpp"
#include "support/recorder.hpp"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>

namespace handover::dense {
namespace {

using client::Json;

// 100 times the handover poses that the planner looks at.
constexpr std::uint64_t kPoses = 800'000;

Json readExperiment(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  Json experiment = Json::parse(in);
  if (experiment.value("format", "") != "handover-experiment/2") {
    throw std::runtime_error(file + " is no handover-experiment/2 file");
  }
  return experiment;
}

TransportProblem problemOf(CellService& service, const Json& experiment, const Json& record,
                           const std::string& task) {
  PlanRequest request;
  request.id = RequestId::random();
  request.client_id = "dense_search";
  request.cell = experiment.at("cell");
  request.task = task;
  request.seed = record.at("seed");
  request.overrides = ctl::overridesOf(record.at("drawn"));
  auto problem = service.problemOf(request, Deadline());
  if (auto* ready = std::get_if<TransportProblem>(&problem)) return std::move(*ready);
  std::string why = "run " + record.at("index").dump() + " is no request that can be planned";
  if (const auto* rejected = std::get_if<Rejected>(&std::get<Outcome>(problem))) {
    for (const Fault& fault : rejected->faults) why += "; " + fault.field + ": " + fault.message;
  }
  throw std::runtime_error(why);
}

bool plannerSolves(const TransportProblem& problem) {
  test::Recorder recorder;
  return std::holds_alternative<Done>(planTransport(problem, recorder, Deadline()));
}

std::string text(const char* format, auto... values) {
  char buffer[200];
  std::snprintf(buffer, sizeof(buffer), format, values...);
  return buffer;
}

double degrees(double angle) { return angle * 180 / M_PI; }

std::string text(const ArmName& name) { return name.robot + "/" + name.arm; }

void print(const char* what, const CauseTally& tally) {
  if (tally.total() == 0) return;
  std::cout << "      " << what << ':';
  for (const CauseCount& count : tally.counts()) {
    std::cout << "  " << toString(count.cause);
    if (count.stage) {
      std::cout << " (holder " << count.stage->holder << ", " << toString(count.stage->action)
                << ')';
    }
    const auto& [one, other] = count.pair;
    if (!one.empty()) std::cout << ' ' << one;
    if (!other.empty()) std::cout << " - " << other;
    std::cout << ' ' << count.count;
  }
  std::cout << '\n';
}

void print(const Json& record, const DenseAnswer& answer, double seconds) {
  const Json& reason = record.at("reason");
  std::cout << "run " << record.at("index") << "  "
            << (reason.is_string() ? reason.get<std::string>()
                                   : record.at("outcome").get<std::string>())
            << "  " << record.at("drawn").dump() << "\n    ";
  if (const auto& plan = answer.plan) {
    std::cout << "solved by dense search: " << text(plan->giver) << " -> " << text(plan->receiver)
              << text(
                     ", receiver's tool at (%.3f, %.3f, %.3f), %.2f m from the midpoint of the "
                     "shoulders, tilt %.0f deg, turn %.0f deg",
                     plan->p_WTr.x(), plan->p_WTr.y(), plan->p_WTr.z(), plan->from_midpoint,
                     degrees(plan->tilt), degrees(plan->turn))
              << (plan->both_maps  ? ", in both maps"
                  : plan->near_map ? ", at the receiver's map"
                                   : ", outside the maps")
              << ", grasps " << plan->giver_grasp << " and " << plan->receiver_grasp
              << (plan->thorough ? ", with a larger budget for motions" : "") << "; pose "
              << answer.poses;
  } else {
    std::cout << "no plan in " << answer.poses << " poses";
    if (answer.poses == answer.grid) std::cout << ", infeasible on this grid";
  }
  std::cout << " of " << answer.grid << text(" (%.1f s)", seconds) << '\n';
  if (answer.invalid) {
    std::cout << "      " << answer.invalid->explanation.text << std::endl;
    return;
  }
  if (!answer.giver_grasps) std::cout << "      no grasp of the giver at the start\n";
  if (!answer.receiver_grasps) std::cout << "      no grasp of the receiver at the goal\n";
  const PoseCounts& counts = answer.counts;
  std::cout << "      poses: " << counts.receiver_reaches_not << " the receiver does not reach, "
            << counts.giver_reaches_not << " the giver does not, " << counts.receiver_touches
            << " the receiver touches something, " << counts.receiver_comes_not
            << " it cannot come to straight, " << counts.giver_touches
            << " the giver touches something, " << counts.held_by_both << " held by both\n";
  print("tuples that ended at", answer.tuples);
  print("tried again with a larger budget, ended at", answer.tuples_again);
  std::cout << std::flush;
}

int run(int argc, char** argv) {
  CLI::App app{"Plans an experiment's failures again over a dense grid of handover poses",
               "dense_search"};
  std::string file, root, task;
  bool again = false;
  std::uint64_t poses = kPoses;
  std::optional<int> only;
  app.add_option("EXPERIMENT", file, "What handoverctl experiment --output wrote")->required();
  app.add_option("--task", task, "The experiment's, which its file does not name");
  app.add_option("--poses", poses, "Handover poses looked at in each run, at most")
      ->capture_default_str();
  app.add_option("--run", only, "This run alone, by its index");
  app.add_flag("--again", again, "Pass over runs that the planner solves now");
  app.add_option("--root", root, "Where config/ and robots/ are");
  app.footer(
      "Example: dense_search e.json --run 17\n"
      "Exit codes: 0 all was looked at, 1 unreadable input, 2 usage.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  const Json experiment = readExperiment(file);
  const std::string cell = experiment.at("cell");
  CellService service(findRoot(root), {cell}, cacheFolder(""), {}, false);
  int failures = 0, solved = 0, planned = 0;
  for (const Json& record : experiment.at("records")) {
    if (record.at("outcome") == "done") {
      ++planned;
      continue;
    }
    if (only && record.at("index") != *only) continue;
    const TransportProblem problem = problemOf(service, experiment, record, task);
    if (again && plannerSolves(problem)) {
      std::cout << "run " << record.at("index") << "  the planner solves it now" << std::endl;
      ++planned;
      continue;
    }
    ++failures;
    const auto start = std::chrono::steady_clock::now();
    const DenseAnswer answer = searchDensely(problem, poses);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    print(record, answer, took.count());
    solved += answer.plan ? 1 : 0;
  }
  std::cout << "dense search solves " << solved << " of " << failures
            << " failures; the planner solved " << planned << " of " << planned + solved
            << std::endl;
  return 0;
}

}  // namespace
}  // namespace handover::dense

int main(int argc, char** argv) {
  try {
    return handover::dense::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "dense_search: " << error.what() << std::endl;
    return 1;
  }
}
