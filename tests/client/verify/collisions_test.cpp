// SPDX-License-Identifier: Apache-2.0
// The advancement along the motion against plain dense sampling.
#include "gantry_plan.hpp"
#include "verify/checks.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

using test::Json;
using Contacts = std::set<std::pair<std::string, std::string>>;

constexpr int kDots = 40;

/// The gantry cell with small boxes strewn where the arms move, larger by `growth` on each side.
Scene sceneWithDots(const test::GantryCell& cell, unsigned seed, double growth) {
  Json file = cell.plan();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(0, 1);
  for (int i = 0; i < kDots; ++i) {
    const double edge = 0.004 + 0.03 * value(random);
    const std::vector<double> at = {1.6 * value(random) - 0.8, 0.2 * value(random) - 0.1,
                                    0.02 + 0.5 * value(random)};
    const double size = edge + 2 * growth;
    file["plan"]["objects"].push_back(
        test::boxObject("dot" + std::to_string(i), {size, size, size}, at));
  }
  Report report;
  return loadScene(parsePlan(file.dump()), cell.root(), report);
}

Contacts reported(const Scene& scene) {
  Report report;
  EXPECT_TRUE(checkStructure(scene, report));
  EXPECT_TRUE(checkHolds(scene, report));
  const Motion motion(scene);
  checkCollisions(motion, ContactRules(scene, {"shelf"}), report);
  Contacts contacts;
  for (const Violation& violation : report.violations) {
    if (violation.kind == "collision") contacts.insert({violation.bodies[0], violation.bodies[1]});
  }
  return contacts;
}

/// Every robot link and the box against every dot at short intervals of time.
Contacts sampled(const Scene& scene) {
  const Motion motion(scene);
  const double end = motion.stage(kReceiverRetreat).end();
  Contacts contacts;
  constexpr int kStates = 3000;
  for (int k = 0; k <= kStates; ++k) {
    const double T = end * k / kStates;
    const std::vector<std::vector<Pose>> links = {motion.linksAt(0, T), motion.linksAt(1, T)};
    for (const SceneBody& mover : scene.bodies) {
      Pose X_WM = Pose::Identity();
      if (mover.robot >= 0) {
        if (mover.link == 0) continue;  // the base stands
        X_WM = links[static_cast<std::size_t>(mover.robot)][static_cast<std::size_t>(mover.link)];
      } else if (mover.object == scene.object) {
        X_WM = motion.objectAt(T);
      } else if (mover.name == "sign") {
        X_WM = motion.otherObjectAt(mover.object, T);
      } else {
        continue;
      }
      for (const SceneBody& dot : scene.bodies) {
        if (dot.name.rfind("dot", 0) != 0 || contacts.count({mover.name, dot.name})) continue;
        const Pose& X_WD = scene.plan.objects[static_cast<std::size_t>(dot.object)].X_WO;
        if (clearance(mover.body, X_WM, dot.body, X_WD, 1e-3).touching) {
          contacts.insert({mover.name, dot.name});
        }
      }
    }
  }
  return contacts;
}

bool mentionsDot(const std::pair<std::string, std::string>& contact) {
  return contact.second.rfind("dot", 0) == 0;
}

TEST(Collisions, AreThoseThatDenseSamplingFinds) {
  const test::GantryCell cell;
  std::size_t contacts = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Contacts found = reported(sceneWithDots(cell, seed, 0));
    // What overlaps by a millimetre must have been found; what was found must be that near.
    for (const auto& contact : sampled(sceneWithDots(cell, seed, -1e-3))) {
      EXPECT_TRUE(found.count(contact)) << contact.first << " and " << contact.second;
      ++contacts;
    }
    const Contacts near = sampled(sceneWithDots(cell, seed, 1e-3));
    for (const auto& contact : found) {
      if (!mentionsDot(contact)) continue;  // two dots cannot meet; the box lies on its rest
      EXPECT_TRUE(near.count(contact)) << contact.first << " and " << contact.second;
    }
  }
  EXPECT_GT(contacts, 20u);
}

TEST(Collisions, LookAtFarPairsSeldom) {
  const test::GantryCell cell;
  Report report;
  const Scene scene = loadScene(parsePlan(cell.plan().dump()), cell.root(), report);
  const Motion motion(scene);
  checkCollisions(motion, ContactRules(scene, {"shelf"}), report);
  std::size_t states = 0, pairs = 0, queries = 0;
  for (const StageChecks& stage : report.stages) {
    states += stage.states;
    pairs += stage.pairs;
    queries += stage.queries;
  }
  EXPECT_TRUE(report.valid());
  EXPECT_GE(queries, pairs);        // each was looked at once at least
  EXPECT_LT(queries, states * 10);  // of dozens of pairs in a state
}

}  // namespace
}  // namespace handover::verify
