// SPDX-License-Identifier: Apache-2.0
// Contacts along the plan, and with one stage run after the other. No contact deeper than half a
// millimetre slips between two looks of the sweep.
#include "verify/checks.hpp"
#include "verify/contact_room.hpp"
#include "verify/pair_sweep.hpp"

#include <cmath>
#include <vector>

namespace handover::verify {
namespace {

class ContactCheck : public PairSweep::Client {
 public:
  /// `in_turn`: the motion has one stage after the other.
  ContactCheck(const Motion& motion, const ContactRules& rules, bool in_turn,
               ReportedPairs& reported, Report& report)
      : motion_(motion),
        scene_(motion.scene()),
        rules_(rules),
        in_turn_(in_turn),
        reported_(reported),
        report_(report) {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const Mount mount = mountOf(scene_, static_cast<int>(b));
      actors_.push_back(actorOfLink(scene_, motion.task(), mount.robot, mount.link));
    }
  }

  void interval(double middle, const std::vector<int>&) override {
    allowances_ = allowancesAt(motion_, middle);
    const int carrier = motion_.carrierAt(middle);
    const int holder = carrier == Motion::kAtStart  ? 0
                       : carrier == Motion::kAtGoal ? motion_.task().last()
                                                    : carrier;
    actors_[static_cast<std::size_t>(scene_.object_body)] =
        motion_.task().actor_of_holder[static_cast<std::size_t>(holder)];
  }

  bool select(PairSweep::Pair& pair, bool rigid) override {
    if (rules_.standing(pair.a, pair.b) || reported_.count({pair.a, pair.b})) return false;
    if (in_turn_ && !betweenActors(pair)) return false;
    pair.depth = rules_.depthAllowed(allowances_, pair.a, pair.b).value_or(-1);
    // Rigid to each other and lawful: they were looked at when they last moved so.
    const bool object = pair.a == scene_.object_body || pair.b == scene_.object_body;
    return !rigid || (object && pair.depth < 0);
  }

  double look(const PairSweep::Pair& pair, const Pose& X_WA, const Pose& X_WB, double T) override {
    const bool allowed = pair.depth >= 0;
    const SceneBody& a = scene_.body(pair.a);
    const SceneBody& b = scene_.body(pair.b);
    const double room =
        contactRoom(a.body, X_WA, b.body, X_WB, allowed ? std::optional(pair.depth) : std::nullopt);
    if (room >= 0 || !reported_.insert({pair.a, pair.b}).second) return room;
    std::string what = a.name + " touches " + b.name;
    if (allowed) {
      what = a.name + " is more than " + text(pair.depth * 1e3) + " mm deep in " + b.name;
    }
    if (in_turn_) what += " when one stage is run after the other";
    const char* kind = in_turn_ ? "order" : allowed ? "depth" : "contact";
    report_.add({pair.stage, T, kind, what, {a.name, b.name}});
    return room;
  }

 private:
  bool betweenActors(const PairSweep::Pair& pair) const {
    const int one = actors_[static_cast<std::size_t>(pair.a)];
    const int other = actors_[static_cast<std::size_t>(pair.b)];
    return one >= 0 && other >= 0 && one != other;
  }

  const Motion& motion_;
  const Scene& scene_;
  const ContactRules& rules_;
  bool in_turn_;
  ReportedPairs& reported_;
  Report& report_;
  std::vector<int> actors_;  ///< per body: that moves it, of O the one of its holder
  Allowances allowances_;
};

/// When hands are away from O.
std::vector<double> leavings(const Motion& motion) {
  std::vector<double> cuts;
  for (int k = 0; k <= motion.task().last(); ++k) {
    const Window window = handWindow(motion, k);
    if (std::isfinite(window.to)) cuts.push_back(window.to);
  }
  return cuts;
}

}  // namespace

void checkContacts(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
                   Report& report) {
  ContactCheck check(motion, rules, false, reported, report);
  PairSweep sweep(motion, leavings(motion), report.nominal);
  sweep.atStart(check);
  sweep.along(check);
}

void checkContactsInTurn(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
                         Report& report) {
  std::vector<double> starts;
  double now = 0;
  for (const PlanStage& stage : motion.scene().plan.stages) {
    starts.push_back(now);
    now += stage.duration();
  }
  const Motion in_turn(motion.curves(), motion.task(), std::move(starts));
  ContactCheck check(in_turn, rules, true, reported, report);
  PairSweep(in_turn, leavings(in_turn), report.in_turn).along(check);
}

}  // namespace handover::verify
