// SPDX-License-Identifier: Apache-2.0
#include "verify/verifier.hpp"

#include "verify/checks.hpp"
#include "verify/unreadable.hpp"

#include <optional>

namespace handover::verify {
namespace {

/// A URDF that was exchanged may lack the plan's very joints: then the wrong hash is the finding.
std::optional<Scene> loadOrBlameHash(Plan plan, const std::filesystem::path& root, Report& report) {
  try {
    return loadScene(std::move(plan), root, report);
  } catch (const Unreadable&) {
    if (report.valid()) throw;
    return std::nullopt;
  }
}

void checkMotion(const Scene& scene, bool measure, Report& report) {
  const Curves curves(scene);
  Task task = makeTask(scene);
  const Motion motion(curves, task, plannedStarts(scene));
  checkTrajectories(motion, report);
  findLeaving(motion, task);
  const bool ordered = checkOrder(motion, report);
  checkHolding(motion, report);
  checkState(motion, report);
  const double tilt_deg = checkUpright(motion, report);
  checkStraight(motion, report);
  checkDexterity(motion, report);
  checkGrips(motion, report);

  const std::set<int> start_rests = startRests(motion), goal_rests = goalRests(motion);
  checkRests(motion, start_rests, goal_rests, report);
  const ContactRules rules(scene, start_rests, goal_rests);
  checkClaims(motion, rules, report);
  ReportedPairs reported;
  checkContacts(motion, rules, reported, report);
  checkContactsInTurn(motion, rules, reported, report);
  if (ordered) checkContactsLate(motion, rules, reported, report);
  if (ordered) checkQuality(motion, rules, tilt_deg, measure, report);
}

}  // namespace

Report verifyPlan(const std::filesystem::path& plan_file, const std::filesystem::path& root,
                  bool measure) {
  Report report;
  const std::optional<Scene> scene = loadOrBlameHash(readPlan(plan_file), root, report);
  if (!scene) return report;
  for (int s = 0; s < scene->stageCount(); ++s) report.stage_names.push_back(scene->stageName(s));
  checkStart(*scene, report);
  if (checkStructure(*scene, report)) checkMotion(*scene, measure, report);
  return report;
}

}  // namespace handover::verify
