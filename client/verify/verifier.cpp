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

}  // namespace

Report verifyPlan(const std::filesystem::path& plan_file, const std::filesystem::path& root) {
  Report report;
  const std::optional<Scene> scene = loadOrBlameHash(readPlan(plan_file), root, report);
  if (!scene) return report;
  checkStart(*scene, report);
  if (!checkStructure(*scene, report)) return report;
  checkTrajectories(*scene, report);
  if (!checkHolds(*scene, report)) return report;

  const Motion motion(*scene);
  checkObjectMotion(motion, report);
  checkDexterity(motion, report);
  checkGrasps(motion, report);
  const ContactRules rules(*scene, goalRests(motion));
  checkClaims(*scene, rules, report);
  checkCollisions(motion, rules, report);
  return report;
}

}  // namespace handover::verify
