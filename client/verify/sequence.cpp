// SPDX-License-Identifier: Apache-2.0
#include "verify/checks.hpp"

#include <cmath>

namespace handover::verify {
namespace {

class SequenceCheck {
 public:
  SequenceCheck(const Motion& motion, Report& report)
      : motion_(motion), scene_(motion.scene()), report_(report) {}

  bool run() {
    if (!edges()) return false;
    const LongestPaths paths = listedOrder(scene_, motion_.task());
    if (paths.contradictory()) {
      report_.add({-1, 0, "order", "stages wait for one another in a circle", {}});
      return false;
    }
    for (const RequiredEdge& edge : requiredEdges(scene_, motion_.task())) {
      const auto reached = paths.between(edge.before, edge.stage);
      if (reached && *reached >= edge.progress - kTimeTolerance) continue;
      violation(edge.stage,
                "must be after " + text(edge.progress) + " s of " + scene_.stageName(edge.before) +
                    " (" + edge.why + "), `after` " +
                    (reached ? "asks for " + text(*reached) + " s" : "does not say so"));
    }
    for (int s = 0; s < scene_.stageCount(); ++s) starts(s);
    return true;
  }

 private:
  void violation(int s, const std::string& what) {
    report_.add({s, scene_.stage(s).start, "order", what, {}});
  }

  /// Form of the edges: progress within the stage, no edge from another arm into a run.
  bool edges() {
    bool sound = true;
    const Task& task = motion_.task();
    for (int s = 0; s < scene_.stageCount(); ++s) {
      for (const After& after : scene_.stage(s).after) {
        if (after.progress < 0 ||
            after.progress > scene_.stage(after.stage).duration() + kTimeTolerance) {
          violation(s, "waits for " + text(after.progress) + " s of " +
                           scene_.stageName(after.stage) + ", which takes " +
                           text(scene_.stage(after.stage).duration()) + " s");
          sound = false;
        }
        if (!task.joined[static_cast<std::size_t>(s)]) continue;
        const PlanHolder& own = scene_.planHolder(scene_.stage(s).holder);
        const PlanHolder& other = scene_.planHolder(scene_.stage(after.stage).holder);
        if (own.robot == other.robot && own.arm == other.arm) continue;
        violation(s,
                  "goes on without a stop, so it cannot wait for " + scene_.stageName(after.stage));
      }
    }
    return sound;
  }

  void starts(int s) {
    for (const After& after : scene_.stage(s).after) {
      const double earliest = scene_.stage(after.stage).start + after.progress;
      if (scene_.stage(s).start >= earliest - kTimeTolerance) continue;
      violation(s, "starts at " + text(scene_.stage(s).start) + " s, its `after` allows " +
                       text(earliest) + " s (" + scene_.stageName(after.stage) + ")");
    }
  }

  const Motion& motion_;
  const Scene& scene_;
  Report& report_;
};

}  // namespace

bool checkOrder(const Motion& motion, Report& report) {
  return SequenceCheck(motion, report).run();
}

}  // namespace handover::verify
