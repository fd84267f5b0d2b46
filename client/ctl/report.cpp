// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>
#include <ostream>

namespace handover::ctl {
namespace {

constexpr std::size_t kCausesShown = 5;

std::string causeText(const RejectCount& reject) {
  std::string text = reject.cause;
  if (reject.pair != NamePair{}) text += " " + reject.pair.first + " - " + reject.pair.second;
  return text;
}

void printCauses(std::ostream& out, const std::vector<RejectCount>& causes) {
  const std::size_t shown = std::min(causes.size(), kCausesShown);
  for (std::size_t i = 0; i < shown; ++i) {
    out << fmt::format("{:12}{:6} x {}\n", "", causes[i].count, causeText(causes[i]));
  }
  if (causes.size() > shown) {
    out << fmt::format("{:12}and {} other causes\n", "", causes.size() - shown);
  }
}

std::string at(const std::array<double, 3>& p) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", p[0], p[1], p[2]);
}

std::string saved(const client::MotionTime& time) {
  if (time.overlap_saves_s < 0.005) return "";
  return fmt::format(", {:.2f} s less than one stage after the other", time.overlap_saves_s);
}

}  // namespace

void Report::add(const PlanEvent& stage) {
  plan_.add(stage);
  elapsed_s_ = stage.elapsed_s;
  std::visit([this](const auto& payload) { print(payload); }, stage.payload);
  out_.flush();
}

void Report::print(const Accepted& accepted) {
  out_ << fmt::format("accepted    revision {}, {} ahead\n", accepted.scene_revision,
                      accepted.queue_place);
}

void Report::print(const SceneSnapshot& scene) {
  out_ << fmt::format("scene       {} {}: {} gives {} to {}; start {}, goal {}\n", scene.cell,
                      scene.task, scene.giver, scene.object, scene.receiver,
                      at(scene.X_WO_start.xyz), at(scene.X_WO_goal.xyz));
}

void Report::print(const ArmSelected& arms) {
  out_ << fmt::format("arms        giver {}, receiver {}\n", arms.giver_arm, arms.receiver_arm);
  for (const ArmScore& score : arms.scores) {
    out_ << fmt::format("{:12}{} {}: {:.4f}{}\n", "", score.robot, score.arm, score.manipulability,
                        score.rejected.empty() ? "" : " - " + score.rejected);
  }
}

void Report::print(const GraspsPruned& pruned) {
  out_ << fmt::format("grasps      {} {}: {} of {} kept\n", pruned.robot, pruned.arm, pruned.kept,
                      pruned.tested);
  printCauses(out_, pruned.rejects);
}

void Report::print(const HandoverCandidates& candidates) {
  out_ << fmt::format(
      "handover    {} to {}: {} voxels, {} poses tried, {} with a giver grasp, {} tuples\n",
      candidates.giver_arm, candidates.receiver_arm, candidates.voxels, candidates.poses_tried,
      candidates.poses, candidates.tuples);
  printCauses(out_, candidates.rejects);
}

void Report::print(const Solution& solution) {
  out_ << fmt::format("solution {:<3}giver {} grasp {}, receiver {} grasp {}, handover at {}\n",
                      solution.index, solution.giver_arm, solution.giver_grasp,
                      solution.receiver_arm, solution.receiver_grasp,
                      at(solution.X_WO_handover.xyz));
  const Dexterity& d = solution.dexterity;
  out_ << fmt::format(
      "{:12}dexterity: receiver place {:.4f}, handover {:.4f}; giver pick {:.4f}, handover "
      "{:.4f}\n",
      "", d.receiver_place, d.receiver_handover, d.giver_pick, d.giver_handover);
}

void Report::print(const StageTrajectory&) {}  // all of them with the outcome, as one table

void Report::printPlan() {
  out_ << fmt::format("\n{:>12}  {:<18} {:<12} {:>7} {:>9} {:>8}\n", "", "stage", "robot", "start",
                      "duration", "samples");
  for (const StageTrajectory* stage : plan_.trajectories()) {
    const double duration = stage->t.empty() ? 0 : stage->t.back();
    out_ << fmt::format("{:>12}  {:<18} {:<12} {:>6.2f}s {:>8.2f}s {:>8}\n", stage->index,
                        toString(stage->kind), stage->robot, stage->start, duration,
                        stage->t.size());
  }
  const client::MotionTime time = plan_.motionTime();
  out_ << fmt::format("{:>12}  the handover takes {:.2f} s{}\n\n", "", time.motion_s, saved(time));
}

void Report::print(const Outcome& outcome) {
  const double ms = 1e3 * elapsed_s_;
  if (const auto* done = std::get_if<Done>(&outcome)) {
    printPlan();
    out_ << fmt::format("done        solution {}{}, {:.1f} ms", done->solution,
                        done->complete ? "" : " (cut by the deadline)", ms);
    if (const auto first = plan_.firstPlanSeconds()) {
      out_ << fmt::format(", first plan after {:.1f} ms", 1e3 * *first);
    }
    out_ << "\n";
  } else if (const auto* failed = std::get_if<Failed>(&outcome)) {
    const Explanation& why = failed->explanation;
    out_ << fmt::format("failed      {}: {} ({}), {:.1f} ms\n", toString(failed->reason), why.text,
                        why.filter, ms);
    printCauses(out_, why.causes);
    for (const Override& fix : why.nearest_fix) {
      out_ << fmt::format("{:12}would work: --set '{}={}'\n", "", fix.path, fix.value);
    }
    if (!why.fix_text.empty()) out_ << fmt::format("{:12}{}\n", "", why.fix_text);
  } else if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    out_ << fmt::format("rejected    {}\n", rejected->reason);
    for (const Fault& fault : rejected->faults) {
      out_ << fmt::format("{:12}{}{}{}\n", "", fault.field, fault.field.empty() ? "" : ": ",
                          fault.message);
    }
  } else {
    out_ << fmt::format("cancelled   after {:.1f} ms\n", ms);
  }
}

void printStatus(std::ostream& out, const DaemonStatus& status) {
  out << fmt::format("daemon {} {}: {}, {} running, {} queued\n", RequestId{status.id}.hex(),
                     status.version, toString(status.state), status.running, status.queued);
  const OutcomeCounters& n = status.counters;
  out << fmt::format("  requests: {} accepted, {} done, {} failed, {} cancelled, {} rejected\n",
                     n.accepted, n.done, n.failed, n.cancelled, n.rejected);
  for (const CellInfo& cell : status.cells) {
    out << fmt::format("  cell {} (revision {}):", cell.name, cell.revision);
    for (const auto& task : cell.tasks) out << ' ' << task;
    out << "\n";
  }
}

}  // namespace handover::ctl
