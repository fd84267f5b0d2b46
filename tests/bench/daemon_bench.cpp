// SPDX-License-Identifier: Apache-2.0
#include "benches.hpp"
#include "ping_pong.hpp"
#include "process.hpp"
#include "rounds.hpp"

#include <handover/client/client.hpp>

#include <signal.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <thread>

namespace handover::bench {
namespace {

using Clock = std::chrono::steady_clock;

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";

/// [paper] Table II: the mean of 100 random butler runs, all solved.
constexpr double kPaperMean = 2.31;

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// When what arrived at the client, from the write of the request [s].
struct Arrivals {
  double accepted = 0, arms = 0, first_plan = 0, outcome = 0;
  bool done = false;
};

/// Asks for one plan and waits for its outcome.
Arrivals ask(client::Client& client, PlanRequest request) {
  Arrivals arrivals;
  const auto begin = Clock::now();
  const auto handle = client.plan(std::move(request), [&](const PlanEvent& event) {
    const double now = secondsSince(begin);
    if (std::holds_alternative<Accepted>(event.payload)) arrivals.accepted = now;
    if (std::holds_alternative<ArmSelected>(event.payload) && arrivals.arms == 0) {
      arrivals.arms = now;
    }
  });
  arrivals.done = std::holds_alternative<Done>(handle.wait());
  if (const auto first_plan = handle.firstPlanTime()) arrivals.first_plan = first_plan->count();
  arrivals.outcome = handle.answerTime().count();
  return arrivals;
}

PlanRequest butlerRequest(std::uint64_t seed) {
  PlanRequest request;
  request.cell = "butler";
  request.mode = SearchMode::kFirst;
  request.wants_fix = false;
  request.seed = seed;
  return request;
}

void waitUntilReady(client::Client& client, const test::Process& daemon) {
  // The first time, maps and grasp sets are made.
  const auto until = Clock::now() + std::chrono::minutes(5);
  while (client.daemons().at(0).state != DaemonState::kReady) {
    if (Clock::now() > until) throw std::runtime_error("the daemon is not ready: " + daemon.err());
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

Report butlerRows(client::Client& client, int requests) {
  std::vector<double> outcome, arms, first_plan;
  for (int k = 0; k < requests; ++k) {
    const Arrivals arrivals = ask(client, butlerRequest(static_cast<std::uint64_t>(k) + 1));
    if (!arrivals.done) {
      throw std::runtime_error("butler: no plan for seed " + std::to_string(k + 1));
    }
    outcome.push_back(arrivals.outcome);
    arms.push_back(arrivals.arms);
    first_plan.push_back(arrivals.first_plan);
  }
  const double mean = std::accumulate(outcome.begin(), outcome.end(), 0.0) / requests;
  const auto row = [](const std::string& name, double value) {
    return Row{name, value, kPaperMean,
               "paper's mean, Table II (2014, another machine: not measured)", "s"};
  };
  return {.rows = {row("butler over DDS, mean", mean),
                   row("butler over DDS, median", quantile(outcome, 0.5)),
                   row("butler over DDS, 95 %", quantile(outcome, 0.95)),
                   row("butler, arms known, median", quantile(arms, 0.5)),
                   row("butler, first whole plan, median", quantile(first_plan, 0.5))},
          .notes = {"Butler: " + std::to_string(requests) +
                    " seeds in the cell as shipped, mode first, one worker; from the write of the "
                    "request until the client has it."}};
}

Report latencyRow(client::Client& client, int pings) {
  const int domain = test::freeDomain();
  const test::Process pong({kBin + "handover-bench", "--pong", std::to_string(domain)});
  Ping ping(domain, std::chrono::seconds(20));
  // Answered at once: nothing is planned.
  PlanRequest late = butlerRequest(1);
  late.deadline_s = 1e-6;
  std::vector<double> ours, bare;
  const int warm_up = std::min(10, pings);
  for (int k = 0; k < warm_up + pings; ++k) {
    const double answered = ping.roundTrip().count();
    const double accepted = ask(client, late).accepted;
    if (k < warm_up) continue;
    bare.push_back(answered);
    ours.push_back(accepted);
  }
  return {
      .rows = {{"request to accepted, median", quantile(ours, 0.5) * 1e6, quantile(bare, 0.5) * 1e6,
                "bare Fast DDS, 256 B there and back, RELIABLE", "us"}},
      .notes = {"Latencies: UDP on loopback on both sides, " + std::to_string(pings) +
                " of each in turn, median."}};
}

}  // namespace

Report daemonBench(const Effort& effort) {
  const int domain = test::freeDomain();
  test::Process daemon({kBin + "handoverd", "serve", "--cell", "butler", "--root",
                        HANDOVER_SOURCE_DIR, "--domain", std::to_string(domain), "--threads", "1"});
  Report report;
  {
    client::Client client({.domain = domain, .client_id = {}, .wait = std::chrono::seconds(20)});
    waitUntilReady(client, daemon);
    ask(client, butlerRequest(1000));  // warm-up
    report.add(butlerRows(client, effort.requests));
    report.add(latencyRow(client, effort.pings));
  }
  daemon.signal(SIGTERM);
  daemon.wait();
  return report;
}

}  // namespace handover::bench
