// SPDX-License-Identifier: Apache-2.0
// The records of an experiment, their summary, and both as file (format handover-experiment/2) and
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

/// How far the search of one request came, by its stream: of the chain of the final solution, or of
/// the arms selected if there is none. A new answer begins anew.
class Funnel {
 public:
  void add(const PlanEvent& event);

  struct Counts {
    /// §IV-C and §IV-B: the first holder's grasps at the start, the last one's at the goal; nullopt
    /// with one holder.
    std::optional<std::uint32_t> grasps_giver, grasps_receiver;
    /// Of the handovers' candidates; nullopt where there is no handover pose.
    std::optional<double> grasps_giver_per_pose, grasps_receiver_per_pose;
    std::uint32_t handover_poses = 0, tuples = 0;
  };

  Counts counts() const;

  /// The crossed maps of the chain's first handover, best cell first.
  std::vector<LatticeCell> lattice() const;

  /// The solution that the outcome names; nullptr without one.
  const Solution* chosen() const;

  /// The object that is moved; empty before the scene is known.
  const std::string& object() const { return object_; }

 private:
  std::vector<ArmName> chain() const;
  /// Whether they are of that handover of the chain.
  static bool ofChain(const HandoverCandidates& candidates, const std::vector<ArmName>& chain);

  std::optional<AnswerId> answer_;
  std::string object_;
  std::vector<ArmName> selected_;
  std::vector<GraspsPruned> pruned_;
  std::vector<HandoverCandidates> candidates_;
  std::vector<Solution> solutions_;
  std::optional<std::uint32_t> final_;  ///< index of a solution
};

/// Where the object changed hands, in W [m].
struct HandoverPlace {
  std::array<double, 3> object{};         ///< the object's origin
  std::array<double, 3> receiver_tool{};  ///< of the next holder
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
  std::optional<double> first_plan_s, first_cost, cost;
  std::optional<Quality> quality;
  Funnel::Counts counts;
  std::optional<double> failure_s;                     ///< to the reason why there is no plan
  std::optional<std::vector<std::string>> violations;  ///< if its plan was verified
  // Not in the file.
  std::string object;  ///< that is moved
  std::vector<HandoverPlace> handovers;
  std::vector<LatticeCell> lattice;
  std::string failure_text;  ///< the plan file of a failure that the report shall show

  bool done() const { return outcome == "done"; }
};

struct ExperimentRecord {
  std::string cell;
  std::uint64_t seed = 1;
  SearchMode mode = SearchMode::kBest;
  SearchWidth search = SearchWidth::kWide;
  Objective objective = Objective::kDexterity;
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

client::Json toJson(const RunRecord& run);
/// The file's `summary`: each mean, spread and least over the records that have the value; null
/// where none has it.
client::Json summaryOf(const ExperimentRecord& experiment);
client::Json toJson(const ExperimentRecord& experiment);

/// The paper's Tables II to IV beside the experiment, where it has the scene; what failed, and why.
void printTable(std::ostream& out, const ExperimentRecord& experiment);

}  // namespace handover::ctl
