// SPDX-License-Identifier: Apache-2.0
// What a task keeps upright: kneeling's full jar, whose goal leans by 10 to 50 degrees.
#include "cells/cell_service.hpp"
#include "core/planning/plan_rules.hpp"
#include "support/plan_text.hpp"
#include "support/recorder.hpp"
#include "support/verified.hpp"

#include <gmock/gmock.h>

#include <algorithm>

namespace handover::test {
namespace {

using testing::HasSubstr;

constexpr double kDegree = M_PI / 180;

/// Serves kneeling and pick_place; its cache lies in the build folder.
CellService& service() {
  static CellService instance(HANDOVER_SOURCE_DIR, {"kneeling", "pick_place"},
                              CacheFolder{HANDOVER_BINARY_DIR "/test-cache/handover"}, {}, false);
  static const bool prepared = [] {
    instance.prepareAll(Deadline());
    return true;
  }();
  (void)prepared;
  return instance;
}

struct Answer {
  std::vector<PlanEventPayload> events;
  Outcome outcome;

  bool done() const { return std::holds_alternative<Done>(outcome); }

  testing::AssertionResult verified() const {
    return test::verified(events, outcome, HANDOVER_SOURCE_DIR);
  }

  /// As if the task had asked for this.
  Answer with(const UprightSnapshot& upright) const {
    Answer other = *this;
    for (PlanEventPayload& event : other.events) {
      if (auto* scene = std::get_if<SceneSnapshot>(&event)) scene->upright = upright;
    }
    return other;
  }
};

PlanRequest requestFor(const std::string& cell, std::vector<Override> overrides) {
  PlanRequest request;
  request.id = RequestId::random();
  request.client_id = "test";
  request.cell = cell;
  request.mode = SearchMode::kFirst;
  request.overrides = std::move(overrides);
  request.wants_fix = false;
  return request;
}

Answer ask(const PlanRequest& request) {
  Recorder recorder;
  Outcome outcome = service().planAlone(request, recorder, Deadline());
  return {std::move(recorder.events), std::move(outcome)};
}

/// Draws of kneeling's goal, spread over what its experiments draw.
std::vector<std::vector<Override>> goals() {
  std::vector<std::vector<Override>> all;
  for (const char* roll : {"10", "20", "30", "40", "50"}) {
    all.push_back({{"tasks.feed.goal.rpy_deg", "[" + std::string(roll) + ", 0, 0]"}});
  }
  return all;
}

const UprightSnapshot kOfTheCell{{0, 0, 1}, 10};

TEST(Upright, KneelingKeepsItsJarWithinTenDegreesOfItsEnds) {
  for (const auto& goal : goals()) {
    const Answer answer = ask(requestFor("kneeling", goal));
    ASSERT_TRUE(answer.done()) << goal[0].value;
    EXPECT_EQ(allOf<SceneSnapshot>(answer.events).at(0).upright, kOfTheCell);
    EXPECT_TRUE(answer.verified());
  }
}

TEST(Upright, WithoutTheKeySomePlansBreakItAndTheVerifierSeesIt) {
  int broken = 0;
  for (auto changes : goals()) {
    changes.push_back({"tasks.feed.upright.within_deg", "180"});
    const Answer answer = ask(requestFor("kneeling", changes));
    ASSERT_TRUE(answer.done()) << changes[0].value;
    EXPECT_TRUE(answer.verified());
    const auto verdict = answer.with(kOfTheCell).verified();
    if (verdict) continue;
    ++broken;
    EXPECT_THAT(verdict.message(), HasSubstr("upright"));
  }
  EXPECT_GE(broken, 2);
}

TEST(Upright, PlansThatBreakItAreHeldBack) {
  int held_back = 0;
  for (auto changes : goals()) {
    changes.push_back({"tasks.feed.upright.within_deg", "180"});
    const PlanRequest request = requestFor("kneeling", changes);
    const Answer answer = ask(request);
    ASSERT_TRUE(answer.done()) << changes[0].value;
    const TransportPlan plan{allOf<Solution>(answer.events).at(0),
                             allOf<StageTrajectory>(answer.events)};
    auto problem = std::get<TransportProblem>(service().problemOf(request, Deadline()));
    CollisionWorld world(problem.collision);
    EXPECT_THAT(brokenRules(problem, plan, world), testing::IsEmpty());
    problem.task.upright = kOfTheCell;
    const auto broken = brokenRules(problem, plan, world);
    EXPECT_EQ(broken.empty(), static_cast<bool>(answer.with(kOfTheCell).verified()));
    if (broken.empty()) continue;
    ++held_back;
    EXPECT_THAT(broken[0], HasSubstr("the object leans too far"));
  }
  EXPECT_GE(held_back, 2);
}

TEST(Upright, HandoverPosesThatLeanTooFarAreLeftOut) {
  PlanRequest request = requestFor("kneeling", {});
  request.mode = SearchMode::kAll;
  const Answer answer = ask(request);
  ASSERT_TRUE(answer.done());
  std::uint32_t leaning = 0;
  for (const auto& counts : allOf<HandoverCandidates>(answer.events)) {
    for (const CauseCount& cause : counts.causes) {
      if (cause.cause == Cause::kTilt) leaning += cause.count;
    }
  }
  EXPECT_GT(leaning, 0u);
  for (const Solution& solution : allOf<Solution>(answer.events)) {
    for (const PoseValue& X_WH : solution.X_WO_handovers) {
      EXPECT_LE(tiltOf(toPose(X_WH).linear().col(2)), (30 + 10 + 0.01) * kDegree);
    }
  }
}

TEST(Upright, ACarriedBoxStaysUprightAllTheWay) {
  const UprightSnapshot within{{0, 0, 1}, 5};
  const Answer free = ask(requestFor("pick_place", {}));
  ASSERT_TRUE(free.done());
  EXPECT_FALSE(free.with(within).verified());  // the key is what keeps it
  const Answer upright =
      ask(requestFor("pick_place", {{"tasks.move.upright", "{axis: [0, 0, 1], within_deg: 5}"}}));
  ASSERT_TRUE(upright.done());
  EXPECT_TRUE(upright.verified());
}

TEST(Upright, QualityTellsTheTiltOfTheAxisThatIsKept) {
  const Answer answer =
      ask(requestFor("pick_place", {{"tasks.move.upright", "{axis: [0, 3, 4], within_deg: 20}"}}));
  ASSERT_TRUE(answer.done());
  EXPECT_TRUE(answer.verified());  // the verifier measures it, too
  for (const Solution& solution : allOf<Solution>(answer.events)) {
    ASSERT_TRUE(solution.quality);
    EXPECT_LE(solution.quality->tilt_deg, 20.01);
  }
}

TEST(Upright, WhatNoHandoverKeepsUprightIsToldSo) {
  // Not at all: Hubo, on its knees, receives from above.
  PlanRequest request = requestFor("kneeling", {{"tasks.feed.upright.within_deg", "0"},
                                                {"tasks.feed.goal.rpy_deg", "[0, 0, 0]"}});
  request.search = SearchWidth::kPaper;
  const Answer answer = ask(request);
  const auto* failed = std::get_if<Failed>(&answer.outcome);
  ASSERT_NE(failed, nullptr);
  EXPECT_EQ(failed->reason, FailureReason::kNoHandoverPose);
  const auto& causes = failed->explanation.causes;
  EXPECT_TRUE(std::any_of(causes.begin(), causes.end(),
                          [](const CauseCount& it) { return it.cause == Cause::kTilt; }));
  EXPECT_THAT(failed->explanation.text, HasSubstr("jar would have leaned too far"));
}

}  // namespace
}  // namespace handover::test
