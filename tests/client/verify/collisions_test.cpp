// SPDX-License-Identifier: Apache-2.0
// The sweep along the motion, the cover of all latenesses and the stages in turn, against plain
// dense sampling.
#include "gantry_plan.hpp"
#include "verify/checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

using test::Json;
using Contacts = std::set<std::pair<std::string, std::string>>;

/// A scene with its motion at the planned starts.
struct Loaded {
  explicit Loaded(const test::GantryCell& cell, const Json& file)
      : scene(loadScene(parsePlan(file.dump()), cell.root(), report)),
        curves(scene),
        task(makeTask(scene)),
        motion(curves, task, plannedStarts(scene)) {
    EXPECT_TRUE(checkStructure(scene, report));
    findLeaving(motion, task);
  }

  ContactRules rules() const { return {scene, startRests(motion), goalRests(motion)}; }

  Report report;
  Scene scene;
  Curves curves;
  Task task;
  Motion motion;
};

Contacts contactsIn(const Report& report) {
  Contacts contacts;
  for (const Violation& violation : report.violations) {
    if (violation.bodies.size() == 2) contacts.insert({violation.bodies[0], violation.bodies[1]});
  }
  return contacts;
}

/// The gantry cell with small boxes strewn where the arms move, larger by `growth` on each side.
/// Half of them stand, half go with the second arm.
Json withDots(const test::GantryCell& cell, unsigned seed, int dots, double growth) {
  test::PlanOptions options;
  options.slack = 1;
  Json file = cell.plan(options);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(0, 1);
  for (int i = 0; i < dots; ++i) {
    const double edge = 0.006 + 0.03 * value(random);
    const std::vector<double> at = {1.6 * value(random) - 0.8, 0.2 * value(random) - 0.1,
                                    0.02 + 0.5 * value(random)};
    const double size = edge + 2 * growth;
    Json dot = test::boxObject("dot" + std::to_string(i), {size, size, size}, at);
    if (i % 2 == 1) {
      // In the frame of the second arm's z_link, which stands at x 0.64, z 0.2, turned by 180 deg.
      dot["X_WO"] = test::pose(at, {0, 0, 0, 1});
      dot["attached_to"] = {{"robot", "r"},
                            {"link", "z_link"},
                            {"X_LO", test::pose({0.64 - at[0], -at[1], at[2] - 0.2})},
                            {"touch_links", {"palm", "left_finger", "right_finger", "base"}}};
      for (Json& stage : file["plan"]["stages"]) {
        stage["holding"].push_back({{"object", dot["name"]},
                                    {"robot", "r"},
                                    {"link", "z_link"},
                                    {"X_LO", dot["attached_to"]["X_LO"]}});
      }
    }
    file["scene"]["objects"].push_back(dot);
  }
  return file;
}

/// Adds the unlawful contacts at short intervals of time.
void sample(const Loaded& loaded, const ContactRules& rules, const Motion& motion, int states,
            Contacts& contacts) {
  const Scene& scene = loaded.scene;
  const int bodies = static_cast<int>(scene.bodies.size());
  std::vector<Pose> poses(scene.bodies.size());
  for (int k = 0; k <= states; ++k) {
    const double T = motion.end() * k / states;
    const Allowances allowances = allowancesAt(motion, T);
    for (int b = 0; b < bodies; ++b) poses[static_cast<std::size_t>(b)] = motion.bodyAt(b, T);
    for (int a = 0; a < bodies; ++a) {
      for (int b = a + 1; b < bodies; ++b) {
        if (rules.standing(a, b) || rules.depthAllowed(allowances, a, b)) continue;
        if (contacts.count({scene.body(a).name, scene.body(b).name})) continue;
        if (clearance(scene.body(a).body, poses[static_cast<std::size_t>(a)], scene.body(b).body,
                      poses[static_cast<std::size_t>(b)], 1e-3)
                .touching) {
          contacts.insert({scene.body(a).name, scene.body(b).name});
        }
      }
    }
  }
}

TEST(Collisions, AreThoseThatDenseSamplingFinds) {
  const test::GantryCell cell;
  std::size_t contacts = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Loaded exact(cell, withDots(cell, seed, 40, 0));
    Report report;
    ReportedPairs reported;
    checkContacts(exact.motion, exact.rules(), reported, report);
    const Contacts found = contactsIn(report);
    // What overlaps by a millimetre must have been found; what was found must be that near.
    const Loaded smaller(cell, withDots(cell, seed, 40, -1.5e-3));
    Contacts sure;
    sample(smaller, smaller.rules(), smaller.motion, 600, sure);
    for (const auto& contact : sure) {
      EXPECT_TRUE(found.count(contact)) << contact.first << " and " << contact.second;
      ++contacts;
    }
    const Loaded larger(cell, withDots(cell, seed, 40, 1e-3));
    Contacts near;
    sample(larger, larger.rules(), larger.motion, 1500, near);
    for (const auto& contact : found) {
      EXPECT_TRUE(near.count(contact)) << contact.first << " and " << contact.second;
    }
  }
  EXPECT_GT(contacts, 20u);
}

/// Starts of a plan in which runs are late by these amounts, `after` kept.
std::vector<double> lateStarts(const Scene& scene, const Task& task,
                               const std::vector<double>& late) {
  std::vector<double> starts = plannedStarts(scene);
  for (std::size_t r = 0; r < task.runs.size(); ++r) {
    for (const int s : task.runs[r]) starts[static_cast<std::size_t>(s)] += late[r];
  }
  for (int round = 0; round < scene.stageCount(); ++round) {
    for (const std::vector<int>& run : task.runs) {
      double push = 0;
      for (const int s : run) {
        for (const After& after : scene.stage(s).after) {
          push = std::max(push, starts[static_cast<std::size_t>(after.stage)] + after.progress -
                                    starts[static_cast<std::size_t>(s)]);
        }
      }
      for (const int s : run) starts[static_cast<std::size_t>(s)] += push;
    }
  }
  return starts;
}

/// Each run late alone, each two, all, and by amounts drawn.
std::vector<std::vector<double>> latenesses(std::size_t runs, double slack, std::mt19937& random) {
  std::vector<std::vector<double>> all;
  const std::vector<double> none(runs, 0.0);
  for (std::size_t a = 0; a < runs; ++a) {
    for (std::size_t b = a; b < runs; ++b) {
      all.push_back(none);
      all.back()[a] = all.back()[b] = slack;
    }
  }
  all.emplace_back(runs, slack);
  std::uniform_real_distribution<double> amount(0, slack);
  for (int i = 0; i < 30; ++i) {
    all.push_back(none);
    for (double& late : all.back()) late = amount(random);
  }
  return all;
}

TEST(Collisions, WhenLateAreNoFewerThanTriedLatenessesFind) {
  const test::GantryCell cell;
  std::size_t only_late = 0;
  std::mt19937 random(5);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Loaded exact(cell, withDots(cell, seed, 30, 0));
    Report nominal, late;
    ReportedPairs reported;
    checkContacts(exact.motion, exact.rules(), reported, nominal);
    checkContactsLate(exact.motion, exact.rules(), reported, late);
    Contacts found = contactsIn(nominal);
    for (const Violation& violation : late.violations) EXPECT_EQ(violation.kind, "order");
    const Contacts found_late = contactsIn(late);
    only_late += found_late.size();
    found.insert(found_late.begin(), found_late.end());

    const Loaded smaller(cell, withDots(cell, seed, 30, -1.5e-3));
    const ContactRules rules = smaller.rules();
    Contacts tried;
    for (const auto& amounts :
         latenesses(smaller.task.runs.size(), smaller.scene.plan.slack, random)) {
      const Motion motion(smaller.curves, smaller.task,
                          lateStarts(smaller.scene, smaller.task, amounts));
      sample(smaller, rules, motion, 100, tried);
    }
    for (const auto& contact : tried) {
      EXPECT_TRUE(found.count(contact)) << contact.first << " and " << contact.second;
    }
  }
  EXPECT_GT(only_late, 3u);
}

TEST(Collisions, InTurnAreThoseThatDenseSamplingFinds) {
  const test::GantryCell cell;
  std::size_t only_in_turn = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Loaded exact(cell, withDots(cell, seed, 40, 0));
    Report nominal, in_turn;
    ReportedPairs reported;
    checkContacts(exact.motion, exact.rules(), reported, nominal);
    checkContactsInTurn(exact.motion, exact.rules(), reported, in_turn);
    only_in_turn += in_turn.violations.size();
    Contacts found = contactsIn(nominal);
    for (const auto& contact : contactsIn(in_turn)) found.insert(contact);
    const Loaded smaller(cell, withDots(cell, seed, 40, -1.5e-3));
    std::vector<double> starts;
    double now = 0;
    for (const PlanStage& stage : smaller.scene.plan.stages) {
      starts.push_back(now);
      now += stage.duration();
    }
    Contacts sure;
    sample(smaller, smaller.rules(), Motion(smaller.curves, smaller.task, starts), 800, sure);
    for (const auto& contact : sure) {
      EXPECT_TRUE(found.count(contact)) << contact.first << " and " << contact.second;
    }
  }
  EXPECT_GT(only_in_turn, 0u);
}

TEST(Collisions, WithoutSlackNothingIsLate) {
  const test::GantryCell cell;
  Json file = withDots(cell, 1, 24, 0);
  file["plan"]["slack_s"] = 0;
  const Loaded loaded(cell, file);
  Report report;
  ReportedPairs reported;
  checkContactsLate(loaded.motion, loaded.rules(), reported, report);
  EXPECT_TRUE(report.valid());
}

TEST(Collisions, LookAtFarPairsSeldom) {
  const test::GantryCell cell;
  const Loaded loaded(cell, cell.plan());
  Report report;
  ReportedPairs reported;
  checkContacts(loaded.motion, loaded.rules(), reported, report);
  EXPECT_TRUE(report.valid());
  EXPECT_GE(report.nominal.queries, report.nominal.pairs);        // each was looked at
  EXPECT_LT(report.nominal.queries, report.nominal.states * 10);  // of dozens in a state
}

}  // namespace
}  // namespace handover::verify
