// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include "plan_file/plan_json.hpp"

#include <handover/common/printable.hpp>

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>
#include <ostream>

namespace handover::ctl {
namespace {

constexpr std::size_t kCausesShown = 7;

std::string nameOf(const ArmName& name) {
  return printable(name.arm.empty() ? name.robot : name.robot + "/" + name.arm);
}

std::string causeText(const CauseCount& cause) {
  const auto& [first, second] = cause.pair;
  std::string text = toString(cause.cause);
  if (!first.empty()) text += " " + printable(first);
  if (!second.empty()) text += " - " + printable(second);
  if (client::sumsOtherPairs(cause)) text += std::string(" of ") + client::kOtherPairs;
  if (cause.stage) {
    text +=
        fmt::format(" ({} of holder {})", toString(cause.stage->action), cause.stage->holder + 1);
  }
  return text;
}

void printCauses(std::ostream& out, const std::vector<CauseCount>& causes) {
  const std::size_t shown = std::min(causes.size(), kCausesShown);
  for (std::size_t i = 0; i < shown; ++i) {
    out << fmt::format("{:12}{:6} x {}\n", "", causes[i].count, causeText(causes[i]));
  }
  if (causes.size() > shown) {
    const std::size_t more = causes.size() - shown;
    out << fmt::format("{:12}and {} other {}\n", "", more, more == 1 ? "cause" : "causes");
  }
}

void printFix(std::ostream& out, const std::vector<Override>& overrides, const std::string& text) {
  for (const Override& change : overrides) {
    out << fmt::format("{:12}would work: --set '{}={}'\n", "", printable(change.path),
                       printable(change.value));
  }
  if (!text.empty()) out << fmt::format("{:12}{}\n", "", printable(text));
}

std::string at(const std::array<double, 3>& p) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", p[0], p[1], p[2]);
}

std::string saved(const client::MotionTime& time) {
  if (time.overlap_saves_s < 0.005) return "";
  return fmt::format(", {:.2f} s less than one stage after the other", time.overlap_saves_s);
}

std::string clearanceText(const ClearanceQuality& clearance) {
  const auto& [first, second] = clearance.pair;
  const bool far = first.empty() && second.empty();
  std::string text = fmt::format("{} {}{:.0f} mm", printable(clearance.between), far ? "over " : "",
                                 1e3 * clearance.least_m);
  if (!far) text += " (" + printable(first) + " - " + printable(second) + ")";
  return text;
}

/// The main figures, in two lines.
void printQuality(std::ostream& out, const Quality& quality) {
  out << fmt::format("{:>12}  at least {:.2f} s, object under way {:.2f} s; grip", "",
                     quality.bound_s, quality.object_s);
  for (const GripQuality& grip : quality.grip) {
    out << fmt::format("{} {:.0f} %", grip.holder == 0 ? "" : ",", 1e2 * grip.of_best);
  }
  out << fmt::format(" of the best; tilt {:.1f} deg, turn {:.0f} of {:.0f} deg\n", quality.tilt_deg,
                     quality.object_turn_deg[0], quality.object_turn_deg[1]);
  std::string between;
  for (const ClearanceQuality& clearance : quality.clearance) {
    between += (between.empty() ? "" : ", ") + clearanceText(clearance);
  }
  out << fmt::format("{:>12}  clearance: {}\n", "", between);
}

}  // namespace

void Report::add(const PlanEvent& event) {
  if (answer_id_ && *answer_id_ != event.answer_id) {
    out_ << "restarted   another answer begins; what came before is void\n";
    explained_ = fix_told_ = false;
  }
  answer_id_ = event.answer_id;
  answer_.add(event);
  elapsed_s_ = event.elapsed_s;
  std::visit([this](const auto& payload) { print(payload); }, event.payload);
  out_.flush();
}

void Report::print(const Accepted& accepted) {
  out_ << fmt::format("accepted    revision {}, {} ahead\n", accepted.scene_revision,
                      accepted.queue_place);
}

void Report::print(const SceneSnapshot& scene) {
  out_ << fmt::format("scene       {} {}: {} from {}{} to {}{}\n", printable(scene.cell),
                      printable(scene.task), printable(scene.object), at(scene.start.X_WO.xyz),
                      scene.start.held_by ? ", held by " + nameOf(*scene.start.held_by) : "",
                      at(scene.goal.X_WO.xyz),
                      scene.goal.end == TransportEnd::kHold ? ", held there" : "");
}

void Report::print(const ArmSelected& arms) {
  std::string chain;
  for (const ArmName& holder : arms.holders)
    chain += (chain.empty() ? "" : " to ") + nameOf(holder);
  out_ << fmt::format("arms        {}\n", chain);
  for (const ArmScore& score : arms.scores) {
    std::string why;
    if (score.rejected != Cause::kUnspecified) why = std::string(" - ") + toString(score.rejected);
    if (!score.object.empty()) why += " " + printable(score.object);
    out_ << fmt::format("{:12}holder {}: {}: {:.4f}{}\n", "", score.holder + 1, nameOf(score.arm),
                        score.manipulability, why);
  }
}

void Report::print(const GraspsPruned& pruned) {
  out_ << fmt::format("grasps      {} at the {}: {} of {} kept\n", nameOf(pruned.arm),
                      toString(pruned.place), pruned.kept, pruned.tested);
  printCauses(out_, pruned.causes);
}

void Report::print(const HandoverCandidates& candidates) {
  out_ << fmt::format(
      "handover {:<3}{} to {}: {} lattice points, {} poses tried, {} with a giver grasp, {} "
      "tuples\n",
      candidates.handover, nameOf(candidates.giver), nameOf(candidates.receiver),
      candidates.lattice_points, candidates.poses_tried, candidates.poses, candidates.tuples);
  printCauses(out_, candidates.causes);
}

void Report::print(const Solution& solution) {
  out_ << fmt::format("solution {:<3}cost {:.3f}", solution.index, solution.cost);
  for (const PoseValue& X_WO : solution.X_WO_handovers) out_ << ", handover at " << at(X_WO.xyz);
  out_ << "\n";
  for (const Holder& holder : solution.holders) {
    out_ << fmt::format("{:12}{} grasp {}, dexterity: take {:.4f}, give {:.4f}\n", "",
                        nameOf(holder.arm), holder.grasp, holder.dexterity.take,
                        holder.dexterity.give);
  }
}

void Report::print(const StageTrajectory&) {}  // all of them with the outcome, as one table

void Report::print(const Note& note) {
  out_ << fmt::format("note        {}\n", printable(note.text));
}

void Report::print(const Failure& failure) {
  out_ << fmt::format("no plan     {}: {} ({}{}), {:.1f} ms\n", toString(failure.reason),
                      printable(failure.explanation.text), printable(failure.explanation.filter),
                      failure.explanation.exhaustive ? ", exhaustive" : "", 1e3 * elapsed_s_);
  printCauses(out_, failure.explanation.causes);
  explained_ = true;
}

void Report::print(const Fix& fix) {
  out_ << "fix\n";
  printFix(out_, fix.overrides, fix.text);
  fix_told_ = true;
}

void Report::printPlan() {
  const Solution* solution = answer_.solution();
  if (solution == nullptr) return;
  out_ << fmt::format("\n{:>12}  {:<10} {:<18} {:>7} {:>9} {:>8}\n", "", "stage", "arm", "start",
                      "duration", "samples");
  for (const StageTrajectory* stage : answer_.trajectories()) {
    const auto& holders = solution->holders;
    const std::string arm =
        stage->holder < holders.size() ? nameOf(holders[stage->holder].arm) : stage->robot;
    const double duration = stage->t.empty() ? 0 : stage->t.back();
    out_ << fmt::format("{:>12}  {:<10} {:<18} {:>6.2f}s {:>8.2f}s {:>8}\n", stage->index,
                        toString(stage->action), arm, stage->start, duration, stage->t.size());
  }
  const client::MotionTime time = answer_.motionTime();
  out_ << fmt::format("{:>12}  the plan takes {:.2f} s{}\n", "", time.motion_s, saved(time));
  if (solution->quality) printQuality(out_, *solution->quality);
  out_ << "\n";
}

void Report::print(const Failed& failed) {
  const Explanation& why = failed.explanation;
  out_ << fmt::format("failed      {}: {} ({}{}), {:.1f} ms\n", toString(failed.reason),
                      printable(why.text), printable(why.filter),
                      why.exhaustive ? ", exhaustive" : "", 1e3 * elapsed_s_);
  if (!explained_) printCauses(out_, why.causes);
  if (!fix_told_) printFix(out_, why.nearest_fix, why.fix_text);
}

void Report::print(const Outcome& outcome) {
  const double ms = 1e3 * elapsed_s_;
  if (const auto* done = std::get_if<Done>(&outcome)) {
    printPlan();
    out_ << fmt::format("done        solution {}{}, {:.1f} ms", done->solution,
                        done->complete ? "" : " (cut by the deadline)", ms);
    if (const auto first = answer_.firstPlanSeconds()) {
      out_ << fmt::format(", first plan after {:.1f} ms", 1e3 * *first);
    }
    out_ << "\n";
  } else if (const auto* failed = std::get_if<Failed>(&outcome)) {
    print(*failed);
  } else if (const auto* rejected = std::get_if<Rejected>(&outcome)) {
    out_ << fmt::format("rejected    {}\n", toString(rejected->reason));
    for (const Fault& fault : rejected->faults) {
      out_ << fmt::format("{:12}{}{}{}\n", "", printable(fault.field),
                          fault.field.empty() ? "" : ": ", printable(fault.message));
    }
  } else {
    out_ << fmt::format("cancelled   {}, after {:.1f} ms\n",
                        toString(std::get<Cancelled>(outcome).cause), ms);
  }
}

void Report::print(const Workspaces&) {}  // to be looked at on the page

namespace {

std::string roleText(const CellInfo& cell) {
  if (cell.role == CellRole::kUndecided || cell.role == CellRole::kShared) {
    return toString(cell.role);
  }
  return fmt::format("{}, epoch {}", toString(cell.role), cell.epoch);
}

}  // namespace

void printStatus(std::ostream& out, const DaemonStatus& status) {
  out << fmt::format(
      "daemon {} {}: {}, up for {:.0f} s, {} running, {} queued, {} kept for others\n",
      RequestId{status.id}.hex(), printable(status.version), toString(status.state),
      status.uptime_s, status.running, status.queued, status.kept_requests);
  const OutcomeCounters& n = status.counters;
  out << fmt::format("  requests: {} accepted, {} done, {} failed, {} cancelled, {} rejected\n",
                     n.accepted, n.done, n.failed, n.cancelled, n.rejected);
  if (const auto& times = status.answer_times) {
    out << fmt::format("  answers: median {:.1f} ms, 95 % within {:.1f} ms\n", times->median_ms,
                       times->p95_ms);
  }
  out << fmt::format(
      "  clients: {}, requests refused: {}, packets dropped: {}, memory: {:.0f} MB\n",
      status.clients, status.refused, status.dropped_packets,
      1e-6 * static_cast<double>(status.memory_bytes));
  for (const CellInfo& cell : status.cells) {
    out << fmt::format("  cell {} (revision {}; {}):", printable(cell.name), cell.revision,
                       roleText(cell));
    for (const auto& task : cell.tasks) out << ' ' << printable(task);
    out << "\n";
  }
}

}  // namespace handover::ctl
