// SPDX-License-Identifier: Apache-2.0
#include "core/handover/overlap.hpp"

#include "core/collision/two_movers.hpp"
#include "core/handover/timed_motion.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace handover {
namespace {

// Starts tried, the earliest first: at every eighth of the greatest head start; then the gap
// between the first that is free and the one before it is halved twice.
constexpr int kHeadStarts = 8;
constexpr int kHalvings = 2;

/// Stages of one arm that follow each other without a break.
class Leg {
 public:
  explicit Leg(const TimedStage& only) : stage_(only.stage), path_(only.path) {}

  Leg(const TimedStage& first, const TimedStage& second) : Leg(first) {
    if (second.stage->dofs != stage_->dofs) {
      throw std::invalid_argument(std::string(toString(second.stage->kind)) +
                                  " moves other joints than the stage before it");
    }
    append(path_, second.path);
  }

  const TimedPath& path() const { return path_; }

  double duration() const { return path_.duration(); }

  /// With what it carries; no contact with the other robot is allowed to either.
  StateChecker checker(const CheckerFactory& checkers) const {
    return checkers.make(stage_->state, *stage_->mover, stage_->dofs, {});
  }

 private:
  const StagePath* stage_;
  TimedPath path_;
};

/// How long [s] before the giver's end the receiver can begin, at most `most`.
/// The giver's way is known to be free while the receiver stands at its start, the receiver's while
/// the giver stands at its end, both in the whole cell: what is left is each against the other
/// while both move.
double headStart(const CheckerFactory& checkers, const Leg& giver, const Leg& receiver,
                 double most) {
  StateChecker giver_checker = giver.checker(checkers);
  StateChecker receiver_checker = receiver.checker(checkers);
  TwoMovers both(giver_checker, receiver_checker);
  const auto free = [&](double head_start) {
    const TimedMotion giver_motion(giver.path(), giver.duration() - head_start, giver.duration());
    const TimedMotion receiver_motion(receiver.path(), 0, head_start);
    return both.validAlong(BothMotions(giver_motion, receiver_motion));
  };
  int eighths = kHeadStarts;
  while (eighths > 0 && !free(most * eighths / kHeadStarts)) --eighths;
  double found = most * eighths / kHeadStarts;
  if (eighths == kHeadStarts) return found;
  double gap = most / kHeadStarts;
  for (int i = 0; i < kHalvings; ++i) {
    gap *= 0.5;
    if (free(found + gap)) found += gap;
  }
  return found;
}

}  // namespace

std::vector<double> startTimes(const CheckerFactory& checkers,
                               const std::vector<TimedStage>& stages) {
  const auto at = [&](StageKind kind) -> const TimedStage& {
    return *std::find_if(stages.begin(), stages.end(),
                         [&](const TimedStage& it) { return it.stage->kind == kind; });
  };
  std::vector<double> starts(stages.size());
  const auto start = [&](StageKind kind) -> double& {
    return starts[static_cast<std::size_t>(&at(kind) - stages.data())];
  };
  const auto end = [&](StageKind kind) { return start(kind) + at(kind).path.duration(); };
  using enum StageKind;

  start(kGiverApproach) = end(kGiverReach);
  start(kGiverGrasp) = end(kGiverApproach);
  start(kGiverLift) = end(kGiverGrasp);
  start(kGiverTransfer) = end(kGiverLift);

  // The receiver is at the object at the earliest when that stands still.
  {
    const Leg giver(at(kGiverLift), at(kGiverTransfer));
    const Leg receiver(at(kReceiverReach), at(kReceiverApproach));
    const double most = std::min(giver.duration(), receiver.duration());
    start(kReceiverReach) = std::max(
        start(kGiverLift), end(kGiverTransfer) - headStart(checkers, giver, receiver, most));
  }
  start(kReceiverApproach) = end(kReceiverReach);
  start(kReceiverGrasp) = std::max(end(kReceiverApproach), end(kGiverTransfer));
  start(kGiverRelease) = end(kReceiverGrasp);
  start(kGiverRetreat) = end(kGiverRelease);

  // It takes the object away when the giver's hand is off it, and lets go when the giver is home.
  {
    const double early = at(kGiverRetreat).early;
    const Leg giver(at(kGiverRetreat));
    const Leg receiver(at(kReceiverTransfer), at(kReceiverPlace));
    const double most = std::min(giver.duration() - early, receiver.duration());
    start(kReceiverTransfer) =
        std::max(start(kGiverRetreat) + early,
                 end(kGiverRetreat) - headStart(checkers, giver, receiver, most));
  }
  start(kReceiverPlace) = end(kReceiverTransfer);
  start(kReceiverRelease) = std::max(end(kReceiverPlace), end(kGiverRetreat));
  start(kReceiverRetreat) = end(kReceiverRelease);
  return starts;
}

}  // namespace handover
