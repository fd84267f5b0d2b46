// SPDX-License-Identifier: Apache-2.0
// The records of an experiment, their summary, and both as file (format handover-experiment/1) and
// as the paper's table.
#pragma once

#include "plan_file/json_writer.hpp"

#include <handover/common/plan_event.hpp>

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace handover::ctl {

/// Means of the paper's 100 runs of a scene, all of which were solved.
struct PaperRow {
  const char* cell;
  const char* table;
  double seconds, grasps_giver, grasps_receiver, handover_poses;
};

/// Nullptr for a cell that is none of the paper's scenes.
const PaperRow* paperRow(const std::string& cell);

/// How far the search of one request came, by its stream: |G_g|, |G_r|, handover poses and tuples
/// of the solution's arms, or of the arms selected if there is no solution.
class Funnel {
 public:
  void add(const PlanEvent& stage);

  struct Counts {
    std::uint32_t grasps_giver = 0, grasps_receiver = 0, handover_poses = 0, tuples = 0;
  };

  Counts counts() const;

  /// The crossed maps of the same arms, best cell first.
  std::vector<LatticeCell> lattice() const;

  /// The solution that the outcome names; nullptr without one.
  const Solution* chosen() const;

 private:
  bool ofTheseArms(const HandoverCandidates& candidates) const;

  std::string giver_, receiver_, giver_arm_, receiver_arm_;
  std::vector<GraspsPruned> pruned_;
  std::vector<HandoverCandidates> candidates_;
  std::vector<Solution> solutions_;
  std::optional<std::uint32_t> final_;  ///< index of a solution
};

/// Where the object changed hands, in W [m].
struct HandoverPlace {
  std::array<double, 3> object{};         ///< the object's origin
  std::array<double, 3> receiver_tool{};  ///< the lattice's cells are places of it
};

/// One run: one draw that was answered.
struct RunRecord {
  std::uint64_t index = 0;
  std::uint64_t seed = 0;  ///< of its request
  client::Json drawn = client::Json::object();
  std::uint32_t redrawn = 0;        ///< draws before it whose start scene touched
  std::vector<NamePair> touched;    ///< in those
  std::string outcome;              ///< done, failed, cancelled or rejected
  std::string reason, explanation;  ///< empty if done
  double planning_time_s = 0;       ///< from the write of the request to the outcome
  std::optional<double> first_plan_s;
  Funnel::Counts counts;
  std::optional<std::vector<std::string>> violations;  ///< if its plan was verified
  // For the page alone, not in the file.
  std::optional<HandoverPlace> handover;
  std::vector<LatticeCell> lattice;

  bool done() const { return outcome == "done"; }
};

struct ExperimentRecord {
  std::string cell;
  std::uint64_t seed = 1;
  SearchMode mode = SearchMode::kBest;
  SearchWidth search = SearchWidth::kWide;
  double stretch = 1;
  std::string machine;
  std::vector<RunRecord> runs;
  // For the page alone, not in the file.
  std::string task, daemon_version;
};

/// Of a sample: p95 and median interpolate between the two nearest values.
struct Spread {
  double mean = 0, median = 0, p95 = 0, max = 0;
};

/// Nullopt for an empty sample.
std::optional<Spread> spreadOf(std::vector<double> sample);

const char* toString(SearchMode mode);
const char* toString(SearchWidth search);

client::Json toJson(const RunRecord& run);
/// The file's `summary`: means over all records, times of first plans over those that have one.
client::Json summaryOf(const ExperimentRecord& experiment);
client::Json toJson(const ExperimentRecord& experiment);

/// The paper's Tables II to IV beside the experiment, where it has the scene; what failed, and why.
void printTable(std::ostream& out, const ExperimentRecord& experiment);

}  // namespace handover::ctl
