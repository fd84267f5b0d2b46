// SPDX-License-Identifier: Apache-2.0
#include "experiment_file.hpp"

#include "plan_file/plan_json.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <ostream>

namespace handover::ctl {
namespace {

using client::Json;

constexpr double kMostClearance = 0.05;  // more is not told (design §5, Quality) [m]

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

/// The values of those runs that have one. @param value from a run to an optional number.
template <typename Value>
std::vector<double> sampleOf(const ExperimentRecord& experiment, Value value) {
  std::vector<double> sample;
  for (const RunRecord& run : experiment.runs) {
    if (const auto it = value(run)) sample.push_back(static_cast<double>(*it));
  }
  return sample;
}

template <typename Value>
std::optional<double> meanOf(const ExperimentRecord& experiment, Value value) {
  const auto spread = spreadOf(sampleOf(experiment, value));
  return spread ? std::optional(spread->mean) : std::nullopt;
}

template <typename Value>
std::optional<Spread> spreadOver(const ExperimentRecord& experiment, Value value) {
  return spreadOf(sampleOf(experiment, value));
}

/// A number of each plan's quality, where it is known.
std::optional<Spread> qualitySpread(const ExperimentRecord& experiment,
                                    const std::function<double(const Quality&)>& value) {
  return spreadOver(experiment, [&value](const RunRecord& run) {
    return run.quality ? std::optional(value(*run.quality)) : std::nullopt;
  });
}

std::optional<Spread> planningTimes(const ExperimentRecord& experiment) {
  return spreadOver(experiment,
                    [](const RunRecord& run) { return std::optional(run.planning_time_s); });
}

std::optional<Spread> firstPlanTimes(const ExperimentRecord& experiment) {
  return spreadOver(experiment, [](const RunRecord& run) { return run.first_plan_s; });
}

std::optional<Spread> failureTimes(const ExperimentRecord& experiment) {
  return spreadOver(experiment, [](const RunRecord& run) { return run.failure_s; });
}

/// Between such bodies [m]; nullopt: not told.
std::optional<double> leastClearance(const Quality& quality, const std::string& between) {
  std::optional<double> least;
  for (const ClearanceQuality& it : quality.clearance) {
    if (it.between == between) least = std::min(least.value_or(it.least_m), it.least_m);
  }
  return least;
}

/// The least distance between such bodies, of each plan.
std::vector<double> clearances(const ExperimentRecord& experiment, const std::string& between) {
  return sampleOf(experiment, [&between](const RunRecord& run) -> std::optional<double> {
    return run.quality ? leastClearance(*run.quality, between) : std::nullopt;
  });
}

Json clearanceJson(std::vector<double> sample) {
  if (sample.empty()) return nullptr;
  std::sort(sample.begin(), sample.end());
  return {{"median", quantile(sample, 0.5)}, {"min", sample.front()}};
}

template <typename T>
Json orNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json orNull(const std::string& text) { return text.empty() ? Json() : Json(text); }

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
  std::optional<double> grasps_giver, grasps_receiver, grasps_giver_per_pose,
      grasps_receiver_per_pose, handover_poses;
};

Means meansOf(const ExperimentRecord& experiment) {
  const auto mean = [&experiment](auto member) {
    return meanOf(experiment, [member](const RunRecord& run) { return run.counts.*member; });
  };
  using Counts = Funnel::Counts;
  return {mean(&Counts::grasps_giver), mean(&Counts::grasps_receiver),
          mean(&Counts::grasps_giver_per_pose), mean(&Counts::grasps_receiver_per_pose),
          meanOf(experiment,
                 [](const RunRecord& run) { return std::optional(run.counts.handover_poses); })};
}

void printSpread(std::ostream& out, const char* what, const std::optional<Spread>& spread) {
  if (!spread) return;
  out << fmt::format("  {:<28}{:>10.4f}{:>10.4f}{:>10.4f}{:>10.4f}\n", what, spread->mean,
                     spread->median, spread->p95, spread->max);
}

/// The paper's |G_g| is a fraction although giver and start never vary, so what it counts is open:
/// both counts are shown.
void printMeans(std::ostream& out, const ExperimentRecord& experiment) {
  const PaperRow* paper = paperRow(experiment.cell);
  const auto times = planningTimes(experiment);
  const Means means = meansOf(experiment);
  const auto row = [&](const char* what, const std::string& theirs, const std::string& ours) {
    out << fmt::format("  {:<44}{:>10}{:>12}\n", what, theirs, ours);
  };
  const auto number = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.2f}", *value) : std::string("-");
  };
  const auto theirs = [&](double PaperRow::*value) {
    return paper == nullptr ? std::string() : number(paper->*value);
  };
  row("means", paper == nullptr ? "" : "paper", "ours");
  row("planning time [s]", theirs(&PaperRow::seconds),
      times ? fmt::format("{:.4f}", times->mean) : "-");
  row("giver's grasps |G_g| at the start (IV-C)", theirs(&PaperRow::grasps_giver),
      number(means.grasps_giver));
  row("giver's grasps for each handover pose", "", number(means.grasps_giver_per_pose));
  row("receiver's grasps |G_r| at the goal (IV-B)", theirs(&PaperRow::grasps_receiver),
      number(means.grasps_receiver));
  row("receiver's grasps for each handover pose", "", number(means.grasps_receiver_per_pose));
  row("handover poses", theirs(&PaperRow::handover_poses), number(means.handover_poses));
  if (paper == nullptr) return;
  out << fmt::format(
      "  paper: Table {}, 100 runs, all solved; its counts are those of --search "
      "paper --mode all\n",
      paper->table);
}

/// A figure of a plan's quality as the table shows it.
struct QualityRow {
  const char* what;
  bool more_is_worse;
  std::function<double(const Quality&)> value;
};

double overBound(const Quality& quality) {
  return quality.bound_s > 0 ? quality.duration_s / quality.bound_s : 1;
}

double weakestGrip(const Quality& quality) {
  double least = 1;
  for (const GripQuality& grip : quality.grip) least = std::min(least, grip.of_best);
  return least;
}

std::function<double(const Quality&)> clearanceOf(const std::string& between) {
  return [between](const Quality& quality) {
    return 1e3 * leastClearance(quality, between).value_or(kMostClearance);
  };
}

std::vector<QualityRow> qualityRows() {
  const auto turn = [](const Quality& q) { return q.object_turn_deg[0] - q.object_turn_deg[1]; };
  return {{"duration [s]", true, [](const Quality& q) { return q.duration_s; }},
          {"duration / bound", true, overBound},
          {"object under way [s]", true, [](const Quality& q) { return q.object_s; }},
          {"clearance, furniture [mm]", false, clearanceOf("furniture")},
          {"clearance, robots [mm]", false, clearanceOf("robots")},
          {"clearance, object [mm]", false, clearanceOf("object")},
          {"weaker grip, of its best", false, weakestGrip},
          {"tilt beyond the ends [deg]", true, [](const Quality& q) { return q.tilt_deg; }},
          {"turn beyond the least [deg]", true, turn},
          {"limit margin", false, [](const Quality& q) { return q.limit_margin; }},
          {"jerk, of its limit", true, [](const Quality& q) { return q.jerk_share; }}};
}

void printQuality(std::ostream& out, const ExperimentRecord& experiment) {
  bool headed = false;
  for (const QualityRow& row : qualityRows()) {
    std::vector<double> sample =
        sampleOf(experiment, [&row](const RunRecord& run) -> std::optional<double> {
          return run.quality ? std::optional(row.value(*run.quality)) : std::nullopt;
        });
    if (sample.empty()) return;
    if (!headed) out << fmt::format("\n  {:<28}{:>10}{:>10}\n", "quality", "median", "worst");
    headed = true;
    std::sort(sample.begin(), sample.end());
    out << fmt::format("  {:<28}{:>10.2f}{:>10.2f}\n", row.what, quantile(sample, 0.5),
                       row.more_is_worse ? sample.back() : sample.front());
  }
}

}  // namespace

const PaperRow* paperRow(const std::string& cell) {
  const auto* row = std::find_if(std::begin(kPaper), std::end(kPaper),
                                 [&cell](const PaperRow& r) { return cell == r.cell; });
  return row == std::end(kPaper) ? nullptr : row;
}

void Funnel::add(const PlanEvent& event) {
  if (answer_ && *answer_ != event.answer_id) *this = Funnel();
  answer_ = event.answer_id;
  if (const auto* scene = std::get_if<SceneSnapshot>(&event.payload)) {
    object_ = scene->object;
  } else if (const auto* arms = std::get_if<ArmSelected>(&event.payload)) {
    selected_ = arms->holders;
  } else if (const auto* pruned = std::get_if<GraspsPruned>(&event.payload)) {
    pruned_.push_back(*pruned);
  } else if (const auto* candidates = std::get_if<HandoverCandidates>(&event.payload)) {
    candidates_.push_back(*candidates);
  } else if (const auto* solution = std::get_if<Solution>(&event.payload)) {
    solutions_.push_back(*solution);
  } else if (const auto* outcome = std::get_if<Outcome>(&event.payload)) {
    if (const auto* done = std::get_if<Done>(outcome)) final_ = done->solution;
  }
}

std::vector<ArmName> Funnel::chain() const {
  const Solution* solution = chosen();
  if (solution == nullptr && !solutions_.empty()) solution = &solutions_.back();
  if (solution == nullptr) return selected_;
  std::vector<ArmName> arms;
  for (const Holder& holder : solution->holders) arms.push_back(holder.arm);
  return arms;
}

bool Funnel::ofChain(const HandoverCandidates& candidates, const std::vector<ArmName>& chain) {
  const std::size_t giver = candidates.handover, receiver = giver + 1;
  return receiver < chain.size() && candidates.giver == chain[giver] &&
         candidates.receiver == chain[receiver];
}

Funnel::Counts Funnel::counts() const {
  const std::vector<ArmName> arms = chain();
  Counts counts;
  if (arms.size() < 2) return counts;
  for (const GraspsPruned& pruned : pruned_) {
    const bool start = pruned.place == PruningPlace::kStart;
    if (start && pruned.arm == arms.front()) counts.grasps_giver = pruned.kept;
    if (!start && pruned.arm == arms.back()) counts.grasps_receiver = pruned.kept;
  }
  std::uint32_t receiver_grasps = 0;
  for (const HandoverCandidates& candidates : candidates_) {
    if (!ofChain(candidates, arms)) continue;
    counts.handover_poses += candidates.poses;
    counts.tuples += candidates.tuples;
    receiver_grasps += candidates.receiver_grasps;
  }
  if (counts.handover_poses > 0) {
    counts.grasps_giver_per_pose = double(counts.tuples) / counts.handover_poses;
    counts.grasps_receiver_per_pose = double(receiver_grasps) / counts.handover_poses;
  }
  return counts;
}

std::vector<LatticeCell> Funnel::lattice() const {
  const std::vector<ArmName> arms = chain();
  for (const HandoverCandidates& candidates : candidates_) {
    if (candidates.handover != 0 || !ofChain(candidates, arms)) continue;
    if (!candidates.lattice.empty()) return candidates.lattice;
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

Json toJson(const RunRecord& run) {
  Json json = {{"index", run.index},
               {"seed", run.seed},
               {"drawn", run.drawn},
               {"redrawn", run.redrawn},
               {"touched", toJson(run.touched)},
               {"outcome", run.outcome},
               {"reason", orNull(run.reason)},
               {"explanation", orNull(run.explanation)},
               {"planning_time_s", run.planning_time_s},
               {"first_plan_s", orNull(run.first_plan_s)},
               {"first_cost", orNull(run.first_cost)},
               {"cost", orNull(run.cost)},
               {"quality", run.quality ? client::toJson(*run.quality) : Json()},
               {"grasps_giver", orNull(run.counts.grasps_giver)},
               {"grasps_receiver", orNull(run.counts.grasps_receiver)},
               {"grasps_giver_per_pose", orNull(run.counts.grasps_giver_per_pose)},
               {"grasps_receiver_per_pose", orNull(run.counts.grasps_receiver_per_pose)},
               {"handover_poses", run.counts.handover_poses},
               {"tuples", run.counts.tuples},
               {"failure_s", orNull(run.failure_s)}};
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
  const auto of_quality = [&experiment](double (*value)(const Quality&)) {
    return toJson(qualitySpread(experiment, value));
  };
  const Means means = meansOf(experiment);
  return {{"runs", experiment.runs.size()},
          {"solved", solvedRuns(experiment)},
          {"redrawn", redrawn},
          {"touched", std::move(touched)},
          {"planning_time_s", toJson(planningTimes(experiment))},
          {"first_plan_s", toJson(firstPlanTimes(experiment))},
          {"duration_s", of_quality([](const Quality& q) { return q.duration_s; })},
          {"object_s", of_quality([](const Quality& q) { return q.object_s; })},
          {"duration_over_bound", of_quality(overBound)},
          {"clearance_furniture_m", clearanceJson(clearances(experiment, "furniture"))},
          {"clearance_robots_m", clearanceJson(clearances(experiment, "robots"))},
          {"grasps_giver_mean", orNull(means.grasps_giver)},
          {"grasps_receiver_mean", orNull(means.grasps_receiver)},
          {"handover_poses_mean", orNull(means.handover_poses)}};
}

Json toJson(const ExperimentRecord& experiment) {
  Json records = Json::array();
  for (const RunRecord& run : experiment.runs) records.push_back(toJson(run));
  return {{"format", "handover-experiment/2"},
          {"cell", experiment.cell},
          {"seed", experiment.seed},
          {"mode", toString(experiment.mode)},
          {"search", toString(experiment.search)},
          {"objective", toString(experiment.objective)},
          {"stretch", experiment.stretch},
          {"machine", experiment.machine},
          {"records", std::move(records)},
          {"summary", summaryOf(experiment)}};
}

void printTable(std::ostream& out, const ExperimentRecord& experiment) {
  out << fmt::format(
      "{}: {} of {} runs solved; seed {}, mode {}, search {}, objective {}, stretch {}; {}\n\n",
      experiment.cell, solvedRuns(experiment), experiment.runs.size(), experiment.seed,
      toString(experiment.mode), toString(experiment.search), toString(experiment.objective),
      experiment.stretch, experiment.machine);
  printMeans(out, experiment);
  out << fmt::format("\n  {:<28}{:>10}{:>10}{:>10}{:>10}\n", "seconds", "mean", "median", "p95",
                     "max");
  printSpread(out, "to the outcome", planningTimes(experiment));
  printSpread(out, "to the first plan", firstPlanTimes(experiment));
  printSpread(out, "to the reason of a failure", failureTimes(experiment));
  printQuality(out, experiment);
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
