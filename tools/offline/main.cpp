// SPDX-License-Identifier: Apache-2.0
// Plans a cell's task in this process, without a daemon: for profilers and debuggers.
#include "cells/cell_service.hpp"
#include "settings/roots.hpp"

#include <handover/client/answer.hpp>

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <fstream>

namespace handover {
namespace {

/// Gathers the events as a client does.
class AnswerSink : public PlanEventSink {
 public:
  void emit(PlanEventPayload payload) override {
    answer.add({RequestId{}, AnswerId{}, sequence_++, 0.0, std::move(payload)});
  }

  client::Answer answer;

 private:
  std::uint32_t sequence_ = 0;
};

/// @param status  of the program.   @return the seconds that it took.
double planOnce(CellService& service, const PlanRequest& request, AnswerSink& sink, int& status) {
  const auto begin = std::chrono::steady_clock::now();
  const Deadline deadline;
  sink.emit(Accepted{});
  Outcome outcome = service.planAlone(request, sink, deadline);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  if (const auto* failed = std::get_if<Failed>(&outcome)) {
    status = 10;
    std::printf("failed: %s: %s\n", toString(failed->reason), failed->explanation.text.c_str());
    for (const CauseCount& cause : failed->explanation.causes) {
      const StageRef stage = cause.stage.value_or(StageRef{});
      std::printf("  %6u %s %s %s (holder %u, %s)\n", cause.count, toString(cause.cause),
                  cause.pair.first.c_str(), cause.pair.second.c_str(), stage.holder,
                  toString(stage.action));
    }
  }
  if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    status = 12;
    for (const Fault& fault : rejected->faults) {
      std::printf("rejected: %s: %s\n", fault.field.c_str(), fault.message.c_str());
    }
  }
  sink.emit(std::move(outcome));
  return took.count();
}

}  // namespace

int run(int argc, char** argv) {
  CLI::App app("Plans a cell's task in this process, without a daemon.");
  PlanRequest request;
  request.client_id = "offline";
  request.mode = SearchMode::kFirst;
  request.wants_fix = false;
  std::string root, output, search = "wide", mode = "first", objective;
  std::vector<std::string> sets;
  int runs = 1;
  app.add_option("--cell", request.cell, "Cell of config/cells, or file")->required();
  app.add_option("--task", request.task, "Task of the cell (default: its first)");
  app.add_option("--chain", request.chain,
                 "Holders in order, A[/arm],B[/arm],... (default: the task's)")
      ->delimiter(',');
  app.add_option("--set", sets, "PATH=VALUE: change the cell; may repeat");
  app.add_option("--seed", request.seed, "Same scene, request and seed: same plan");
  app.add_option("--search", search, "paper or wide (default)")
      ->check(CLI::IsMember({"paper", "wide"}));
  app.add_option("--mode", mode, "first (default), best or all")
      ->check(CLI::IsMember({"first", "best", "all"}));
  app.add_option("--objective", objective, "balanced (default), time or dexterity")
      ->check(CLI::IsMember({"balanced", "time", "dexterity"}));
  app.add_option("--runs", runs, "How often the same is planned");
  app.add_option("--root", root, "Folder that holds config/ and robots/");
  app.add_option("--output", output, "Write the plan file of the last run");
  app.footer(
      "Example: plan_offline --cell butler --runs 10 --output plan.json\n"
      "Exit codes: 0 planned, 1 unreadable input, 2 usage, 10 no plan, 12 rejected.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  request.search = fromString<SearchWidth>(search).value_or(SearchWidth::kWide);
  request.mode = fromString<SearchMode>(mode).value_or(SearchMode::kFirst);
  request.objective = fromString<Objective>(objective).value_or(Objective::kUnspecified);
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    request.overrides.push_back({set.substr(0, equals), set.substr(equals + 1)});
  }
  const auto progress = [](const std::string& what, double fraction) {
    if (fraction >= 1) std::fprintf(stderr, "%s\n", what.c_str());
  };
  CellService service(findRoot(root), {request.cell}, cacheFolder(""), progress, false);
  service.prepareAll(Deadline{});
  int status = 0;
  for (int i = 0; i < runs; ++i) {
    AnswerSink sink;
    std::printf("%.1f ms\n", 1e3 * planOnce(service, request, sink, status));
    if (!output.empty() && sink.answer.writable()) std::ofstream(output) << sink.answer.text();
  }
  return status;
}

}  // namespace handover

int main(int argc, char** argv) {
  try {
    return handover::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "plan_offline: %s\n", error.what());
    return 1;
  }
}
