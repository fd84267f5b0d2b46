// SPDX-License-Identifier: Apache-2.0
// Every cell that comes with the product, planned as it stands: valid, smooth, the same each time.
#include "cells/cell_service.hpp"
#include "core/task/stages.hpp"
#include "runtime/memory_endpoint.hpp"
#include "runtime/runtime.hpp"
#include "support/joined_stages.hpp"
#include "support/plan_text.hpp"
#include "support/recorder.hpp"
#include "support/verified.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

namespace handover::test {
namespace {

struct ShippedCell {
  const char* name;
  std::size_t holders;
  TransportEnd end;
};

constexpr ShippedCell kCells[] = {
    {"butler", 2, TransportEnd::kRelease},     {"butler_left", 2, TransportEnd::kRelease},
    {"stool", 2, TransportEnd::kHold},         {"kneeling", 2, TransportEnd::kHold},
    {"relay", 3, TransportEnd::kRelease},      {"hand_to_hand", 2, TransportEnd::kRelease},
    {"pick_place", 1, TransportEnd::kRelease}, {"serve_person", 2, TransportEnd::kRelease}};

/// One service for all tests of the program; its cache lies in the build folder.
CellService& service() {
  static CellService instance = [] {
    std::vector<std::string> names;
    for (const ShippedCell& cell : kCells) names.emplace_back(cell.name);
    return CellService(HANDOVER_SOURCE_DIR, names,
                       std::filesystem::path(HANDOVER_BINARY_DIR "/test-cache/handover"), {},
                       false);
  }();
  static const bool prepared = [] {
    instance.prepareAll(Deadline());
    return true;
  }();
  (void)prepared;
  return instance;
}

PlanRequest requestFor(const std::string& cell, std::vector<std::string> chain = {}) {
  PlanRequest request;
  request.id = RequestId::random();
  request.client_id = "test";
  request.cell = cell;
  request.chain = std::move(chain);
  request.wants_fix = false;
  return request;
}

struct Answer {
  std::vector<PlanEventPayload> events;
  Outcome outcome;

  template <typename T>
  std::vector<T> all() const {
    return allOf<T>(events);
  }

  /// "scene" and "plan" of the plan file.
  std::string text() const { return planMember(planText(events, outcome)); }

  /// The stages of the final solution.
  std::vector<StageTrajectory> stages() const {
    std::vector<StageTrajectory> all = allOf<StageTrajectory>(events);
    const std::uint32_t last = std::get<Done>(outcome).solution;
    std::erase_if(all, [&](const StageTrajectory& stage) { return stage.solution != last; });
    return all;
  }

  Solution solution() const { return all<Solution>().at(std::get<Done>(outcome).solution); }
};

Answer ask(const PlanRequest& request) {
  Recorder recorder;
  Outcome outcome = service().planAlone(request, recorder, Deadline());
  return {std::move(recorder.events), std::move(outcome)};
}

/// The answer to the cell as it stands, made once.
const Answer& nominal(const std::string& cell) {
  static std::map<std::string, Answer> answers;
  const auto known = answers.find(cell);
  return known != answers.end() ? known->second
                                : answers.emplace(cell, ask(requestFor(cell))).first->second;
}

std::string reasonOf(const Outcome& outcome) {
  const auto* failed = std::get_if<Failed>(&outcome);
  if (failed == nullptr) return "outcome " + std::to_string(outcome.index());
  return std::string(toString(failed->reason)) + ": " + failed->explanation.text;
}

class Shipped : public testing::TestWithParam<ShippedCell> {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::holds_alternative<Done>(answer().outcome)) << reasonOf(answer().outcome);
  }

  const Answer& answer() const { return nominal(GetParam().name); }
};

INSTANTIATE_TEST_SUITE_P(Cells, Shipped, testing::ValuesIn(kCells),
                         [](const auto& cell) { return std::string(cell.param.name); });

TEST_P(Shipped, IsPlannedAndVerified) {
  EXPECT_TRUE(verified(answer().events, answer().outcome, HANDOVER_SOURCE_DIR));
  const Solution solution = answer().solution();
  EXPECT_EQ(solution.holders.size(), GetParam().holders);
  EXPECT_EQ(solution.X_WO_handovers.size() + 1, GetParam().holders);
}

TEST_P(Shipped, HasTheStagesOfItsChain) {
  const auto expected = makeStages({GetParam().holders, false, GetParam().end});
  const auto stages = answer().stages();
  ASSERT_EQ(stages.size(), expected.size());
  for (std::size_t i = 0; i < stages.size(); ++i) {
    EXPECT_EQ(stages[i].index, i);
    EXPECT_EQ(stages[i].holder, expected[i].holder) << i;
    EXPECT_EQ(stages[i].action, expected[i].action) << i;
  }
  if (GetParam().end != TransportEnd::kHold) return;
  // Nobody lets go in the end.
  const std::uint32_t last = stages.back().holder;
  EXPECT_EQ(last + 1, GetParam().holders);
  EXPECT_EQ(stages.back().action, StageAction::kCarry);
  EXPECT_TRUE(std::none_of(stages.begin(), stages.end(), [&](const StageTrajectory& stage) {
    return stage.holder == last && stage.action == StageAction::kRelease;
  }));
}

TEST_P(Shipped, StagesJoinInPlaceSpeedAndAcceleration) {
  const auto fault = stagesFault(answer().all<SceneSnapshot>().at(0), answer().stages());
  EXPECT_FALSE(fault.has_value()) << *fault;
}

TEST_P(Shipped, IsTheSameToTheByteWhenPlannedAgain) {
  const Answer again = ask(requestFor(GetParam().name));
  EXPECT_GT(answer().text().size(), 1000u);
  EXPECT_EQ(again.text(), answer().text());
}

TEST(ShippedCells, AreTheSameToTheByteForTwoWorkers) {
  MemoryEndpoint endpoint;
  RuntimeSettings settings{.threads = 2, .id = {9}};
  settings.sharing = CellSharing::kShared;
  Runtime runtime(service(), endpoint, settings);
  runtime.start();
  std::vector<PlanRequest> requests;
  for (const ShippedCell& cell : kCells) {
    requests.push_back(requestFor(cell.name));
    endpoint.send(requests.back());
  }
  for (const PlanRequest& request : requests) {
    const auto ended = [](const std::vector<PlanEvent>& events) {
      return std::holds_alternative<Outcome>(events.back().payload);
    };
    const auto events = endpoint.waitFor(request.id, ended, std::chrono::minutes(5));
    ASSERT_TRUE(events.has_value()) << request.cell;
    Answer answer;
    answer.outcome = std::get<Outcome>(events->back().payload);
    // Without what the runtime adds at either end.
    for (std::size_t i = 1; i + 1 < events->size(); ++i) {
      answer.events.push_back((*events)[i].payload);
    }
    ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome)) << reasonOf(answer.outcome);
    EXPECT_EQ(answer.text(), nominal(request.cell).text()) << request.cell;
  }
  runtime.stop();
}

/// How many holders the planner takes where it may choose.
std::size_t autoHolders(const std::string& cell) {
  const Answer answer = ask(requestFor(cell, {kAutoChain}));
  EXPECT_TRUE(std::holds_alternative<Done>(answer.outcome)) << reasonOf(answer.outcome);
  if (!std::holds_alternative<Done>(answer.outcome)) return 0;
  EXPECT_TRUE(verified(answer.events, answer.outcome, HANDOVER_SOURCE_DIR));
  return answer.solution().holders.size();
}

TEST(Chains, OfOtherArmsAreSearchedWhereGiversCannotLeave) {
  PlanRequest request = requestFor("relay");
  request.seed = 244;
  request.overrides = {{"robots.first.base.xyz", "[0.16805703793, 0.35084903542, 0]"}};
  const Answer answer = ask(request);
  ASSERT_TRUE(std::holds_alternative<Done>(answer.outcome)) << reasonOf(answer.outcome);
  EXPECT_TRUE(verified(answer.events, answer.outcome, HANDOVER_SOURCE_DIR));
}

TEST(AutoChain, OfPickAndPlaceIsOneHolder) { EXPECT_EQ(autoHolders("pick_place"), 1u); }

TEST(AutoChain, OfTheRelayIsThreeHolders) { EXPECT_EQ(autoHolders("relay"), 3u); }

std::size_t notesOf(const Answer& answer, const std::string& code) {
  const auto notes = answer.all<Note>();
  return static_cast<std::size_t>(std::count_if(
      notes.begin(), notes.end(), [&](const Note& note) { return note.code == code; }));
}

TEST(Notes, TellThatOneArmWouldDo) {
  PlanRequest near = requestFor("serve_person");
  near.overrides = {{"tasks.serve.goal.xyz", "[-0.13, -0.20, 0.7402]"}};
  const Answer two = ask(near);
  ASSERT_TRUE(std::holds_alternative<Done>(two.outcome)) << reasonOf(two.outcome);
  EXPECT_EQ(two.solution().holders.size(), 2u);
  EXPECT_TRUE(verified(two.events, two.outcome, HANDOVER_SOURCE_DIR));
  EXPECT_EQ(notesOf(two, "one_arm_would_do"), 1u);
  // It would.
  near.chain = {"crichton/right"};
  const Answer one = ask(near);
  ASSERT_TRUE(std::holds_alternative<Done>(one.outcome)) << reasonOf(one.outcome);
  EXPECT_TRUE(verified(one.events, one.outcome, HANDOVER_SOURCE_DIR));
  // Not said where it would not, or where one arm does it.
  EXPECT_EQ(notesOf(one, "one_arm_would_do"), 0u);
  EXPECT_EQ(notesOf(nominal("butler"), "one_arm_would_do"), 0u);
  EXPECT_EQ(notesOf(nominal("pick_place"), "one_arm_would_do"), 0u);
}

TEST(PaperSearch, IsRefusedForChainsOfOneAndOfThree) {
  for (const char* cell : {"pick_place", "relay"}) {
    PlanRequest request = requestFor(cell);
    request.search = SearchWidth::kPaper;
    const Answer answer = ask(request);
    const auto* rejected = std::get_if<Rejected>(&answer.outcome);
    ASSERT_NE(rejected, nullptr) << cell << ' ' << reasonOf(answer.outcome);
    EXPECT_EQ(rejected->reason, RejectionReason::kBadRequest);
    ASSERT_EQ(rejected->faults.size(), 1u);
    EXPECT_EQ(rejected->faults[0].field, "search");
    EXPECT_TRUE(answer.events.empty());
  }
}

}  // namespace
}  // namespace handover::test
