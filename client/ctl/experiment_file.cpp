// SPDX-License-Identifier: Apache-2.0
#include "experiment_file.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>

namespace handover::ctl {
namespace {

using client::Json;

constexpr PaperRow kPaper[] = {{"butler", "II", 2.31, 32.36, 39.77, 16.64},
                               {"butler_left", "II", 2.31, 32.36, 39.77, 16.64},
                               {"stool", "III", 4.62, 56.87, 143.28, 89.49},
                               {"kneeling", "IV", 3.18, 30.45, 72.91, 39.89}};

double quantile(const std::vector<double>& sorted, double fraction) {
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - std::floor(place)) * (sorted[above] - sorted[below]);
}

template <typename Value>
double meanOf(const ExperimentRecord& experiment, Value value) {
  if (experiment.runs.empty()) return 0;
  double sum = 0;
  for (const RunRecord& run : experiment.runs) sum += value(run);
  return sum / static_cast<double>(experiment.runs.size());
}

std::optional<Spread> planningTimes(const ExperimentRecord& experiment) {
  std::vector<double> times;
  for (const RunRecord& run : experiment.runs) times.push_back(run.planning_time_s);
  return spreadOf(std::move(times));
}

std::optional<Spread> firstPlanTimes(const ExperimentRecord& experiment) {
  std::vector<double> times;
  for (const RunRecord& run : experiment.runs) {
    if (run.first_plan_s) times.push_back(*run.first_plan_s);
  }
  return spreadOf(std::move(times));
}

std::size_t solvedRuns(const ExperimentRecord& experiment) {
  return static_cast<std::size_t>(std::count_if(experiment.runs.begin(), experiment.runs.end(),
                                                [](const RunRecord& run) { return run.done(); }));
}

std::map<NamePair, int> touchedPairs(const ExperimentRecord& experiment) {
  std::map<NamePair, int> pairs;
  for (const RunRecord& run : experiment.runs) {
    for (const NamePair& pair : run.touched) ++pairs[pair];
  }
  return pairs;
}

Json toJson(const std::optional<Spread>& spread) {
  if (!spread) return nullptr;
  return {{"mean", spread->mean},
          {"median", spread->median},
          {"p95", spread->p95},
          {"max", spread->max}};
}

Json toJson(const std::vector<NamePair>& pairs) {
  Json list = Json::array();
  for (const auto& [a, b] : pairs) list.push_back(Json::array({a, b}));
  return list;
}

struct Means {
  double grasps_giver, grasps_receiver, handover_poses;
};

Means meansOf(const ExperimentRecord& experiment) {
  return {meanOf(experiment, [](const RunRecord& r) { return r.counts.grasps_giver; }),
          meanOf(experiment, [](const RunRecord& r) { return r.counts.grasps_receiver; }),
          meanOf(experiment, [](const RunRecord& r) { return r.counts.handover_poses; })};
}

void printSpread(std::ostream& out, const char* what, const std::optional<Spread>& spread) {
  if (!spread) return;
  out << fmt::format("  {:<28}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}\n", what, spread->mean,
                     spread->median, spread->p95, spread->max);
}

void printMeans(std::ostream& out, const ExperimentRecord& experiment) {
  const PaperRow* paper = paperRow(experiment.cell);
  const auto times = planningTimes(experiment);
  const Means means = meansOf(experiment);
  const double seconds = times ? times->mean : 0;
  const auto row = [&](const char* what, const char* paper_text, const std::string& ours) {
    out << fmt::format("  {:<28}{:>10}{:>12}\n", what, paper_text, ours);
  };
  const auto number = [](double value) { return fmt::format("{:.2f}", value); };
  const auto theirs = [&](double PaperRow::*value) {
    return paper == nullptr ? std::string() : number(paper->*value);
  };
  row("means", paper == nullptr ? "" : "paper", "ours");
  row("planning time [s]", theirs(&PaperRow::seconds).c_str(), fmt::format("{:.4f}", seconds));
  row("giver's grasps |G_g|", theirs(&PaperRow::grasps_giver).c_str(), number(means.grasps_giver));
  row("receiver's grasps |G_r|", theirs(&PaperRow::grasps_receiver).c_str(),
      number(means.grasps_receiver));
  row("handover poses", theirs(&PaperRow::handover_poses).c_str(), number(means.handover_poses));
  if (paper == nullptr) return;
  out << fmt::format(
      "  paper: Table {}, 100 runs, all solved; its counts are those of --search "
      "paper --mode all\n",
      paper->table);
}

}  // namespace

const PaperRow* paperRow(const std::string& cell) {
  const auto* row = std::find_if(std::begin(kPaper), std::end(kPaper),
                                 [&cell](const PaperRow& r) { return cell == r.cell; });
  return row == std::end(kPaper) ? nullptr : row;
}

void Funnel::add(const PlanEvent& stage) {
  if (const auto* scene = std::get_if<SceneSnapshot>(&stage.payload)) {
    giver_ = scene->giver;
    receiver_ = scene->receiver;
  } else if (const auto* arms = std::get_if<ArmSelected>(&stage.payload)) {
    giver_arm_ = arms->giver_arm;
    receiver_arm_ = arms->receiver_arm;
  } else if (const auto* pruned = std::get_if<GraspsPruned>(&stage.payload)) {
    pruned_.push_back(*pruned);
  } else if (const auto* candidates = std::get_if<HandoverCandidates>(&stage.payload)) {
    candidates_.push_back(*candidates);
  } else if (const auto* solution = std::get_if<Solution>(&stage.payload)) {
    giver_arm_ = solution->giver_arm;
    receiver_arm_ = solution->receiver_arm;
    solutions_.push_back(*solution);
  } else if (const auto* outcome = std::get_if<Outcome>(&stage.payload)) {
    if (const auto* done = std::get_if<Done>(outcome)) final_ = done->solution;
  }
}

bool Funnel::ofTheseArms(const HandoverCandidates& candidates) const {
  return candidates.giver_arm == giver_arm_ && candidates.receiver_arm == receiver_arm_;
}

Funnel::Counts Funnel::counts() const {
  Counts counts;
  for (const GraspsPruned& pruned : pruned_) {
    if (pruned.robot == giver_ && pruned.arm == giver_arm_) counts.grasps_giver = pruned.kept;
    if (pruned.robot == receiver_ && pruned.arm == receiver_arm_) {
      counts.grasps_receiver = pruned.kept;
    }
  }
  for (const HandoverCandidates& candidates : candidates_) {
    if (!ofTheseArms(candidates)) continue;
    counts.handover_poses += candidates.poses;
    counts.tuples += candidates.tuples;
  }
  return counts;
}

std::vector<LatticeCell> Funnel::lattice() const {
  for (const HandoverCandidates& candidates : candidates_) {
    if (ofTheseArms(candidates) && !candidates.lattice.empty()) return candidates.lattice;
  }
  return {};
}

const Solution* Funnel::chosen() const {
  for (const Solution& solution : solutions_) {
    if (solution.index == final_) return &solution;
  }
  return nullptr;
}

std::optional<Spread> spreadOf(std::vector<double> sample) {
  if (sample.empty()) return std::nullopt;
  std::sort(sample.begin(), sample.end());
  const double sum = std::accumulate(sample.begin(), sample.end(), 0.0);
  return Spread{sum / static_cast<double>(sample.size()), quantile(sample, 0.5),
                quantile(sample, 0.95), sample.back()};
}

const char* toString(SearchMode mode) {
  switch (mode) {
    case SearchMode::kFirst:
      return "first";
    case SearchMode::kBest:
      return "best";
    case SearchMode::kAll:
      return "all";
  }
  return "best";
}

const char* toString(SearchWidth search) {
  return search == SearchWidth::kPaper ? "paper" : "wide";
}

Json toJson(const RunRecord& run) {
  Json json = {{"index", run.index},
               {"seed", run.seed},
               {"drawn", run.drawn},
               {"redrawn", run.redrawn},
               {"touched", toJson(run.touched)},
               {"outcome", run.outcome},
               {"reason", run.reason.empty() ? Json() : Json(run.reason)},
               {"explanation", run.explanation.empty() ? Json() : Json(run.explanation)},
               {"planning_time_s", run.planning_time_s},
               {"first_plan_s", run.first_plan_s ? Json(*run.first_plan_s) : Json()},
               {"grasps_giver", run.counts.grasps_giver},
               {"grasps_receiver", run.counts.grasps_receiver},
               {"handover_poses", run.counts.handover_poses},
               {"tuples", run.counts.tuples}};
  if (run.violations) json["violations"] = *run.violations;
  return json;
}

Json summaryOf(const ExperimentRecord& experiment) {
  std::uint64_t redrawn = 0;
  for (const RunRecord& run : experiment.runs) redrawn += run.redrawn;
  Json touched = Json::array();
  for (const auto& [pair, count] : touchedPairs(experiment)) {
    touched.push_back({{"pair", {pair.first, pair.second}}, {"count", count}});
  }
  const Means means = meansOf(experiment);
  return {{"runs", experiment.runs.size()},
          {"solved", solvedRuns(experiment)},
          {"redrawn", redrawn},
          {"touched", std::move(touched)},
          {"planning_time_s", toJson(planningTimes(experiment))},
          {"first_plan_s", toJson(firstPlanTimes(experiment))},
          {"grasps_giver_mean", means.grasps_giver},
          {"grasps_receiver_mean", means.grasps_receiver},
          {"handover_poses_mean", means.handover_poses}};
}

Json toJson(const ExperimentRecord& experiment) {
  Json records = Json::array();
  for (const RunRecord& run : experiment.runs) records.push_back(toJson(run));
  return {{"format", "handover-experiment/1"},
          {"cell", experiment.cell},
          {"seed", experiment.seed},
          {"mode", toString(experiment.mode)},
          {"search", toString(experiment.search)},
          {"stretch", experiment.stretch},
          {"machine", experiment.machine},
          {"records", std::move(records)},
          {"summary", summaryOf(experiment)}};
}

void printTable(std::ostream& out, const ExperimentRecord& experiment) {
  out << fmt::format("{}: {} of {} runs solved; seed {}, mode {}, search {}, stretch {}; {}\n\n",
                     experiment.cell, solvedRuns(experiment), experiment.runs.size(),
                     experiment.seed, toString(experiment.mode), toString(experiment.search),
                     experiment.stretch, experiment.machine);
  printMeans(out, experiment);
  out << fmt::format("\n  {:<28}{:>10}{:>10}{:>10}{:>10}\n", "seconds", "mean", "median", "p95",
                     "max");
  printSpread(out, "to the outcome", planningTimes(experiment));
  printSpread(out, "to the first plan", firstPlanTimes(experiment));
  for (const auto& [pair, count] : touchedPairs(experiment)) {
    out << fmt::format("\n  drawn again {} x, the start touches: {} - {}", count, pair.first,
                       pair.second);
  }
  out << "\n";
  for (const RunRecord& run : experiment.runs) {
    if (!run.done()) {
      out << fmt::format("  run {:03} {}: {} ({})\n", run.index, run.outcome, run.reason,
                         run.explanation);
    }
    if (!run.violations) continue;
    for (const std::string& violation : *run.violations) {
      out << fmt::format("  run {:03} violates: {}\n", run.index, violation);
    }
  }
}

}  // namespace handover::ctl
