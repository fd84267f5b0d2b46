// SPDX-License-Identifier: Apache-2.0
// The checkers of the crash suite find what breaks a rule, and shrinking leaves what fails.
#include "faults.hpp"
#include "wire_checker.hpp"

#include <gmock/gmock.h>

#include <algorithm>

namespace handover::test {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

HeardEvent heard(std::uint32_t sequence, PlanEventPayload payload, std::uint8_t answer = 1,
                 std::uint8_t daemon = 1) {
  HeardEvent event;
  event.event.answer_id[0] = answer;
  event.event.sequence = sequence;
  event.event.payload = std::move(payload);
  event.writer[0] = daemon;
  return event;
}

TEST(WireFaults, WholeAndBrokenOffAnswersKeepTheRules) {
  EXPECT_THAT(wireFaults({heard(0, Accepted{}), heard(1, SceneSnapshot{}), heard(2, Outcome{})}),
              IsEmpty());
  EXPECT_THAT(
      wireFaults({heard(0, Accepted{}), heard(0, Accepted{}, 2, 2), heard(1, Outcome{}, 2, 2)}),
      IsEmpty());
}

TEST(WireFaults, EachRuleIsHeld) {
  EXPECT_THAT(wireFaults({heard(0, Accepted{}), heard(2, Outcome{})}),
              ElementsAre(HasSubstr("after 1 events")));
  EXPECT_THAT(wireFaults({heard(0, Outcome{}), heard(1, Outcome{})}),
              ElementsAre(HasSubstr("after the outcome")));
  EXPECT_THAT(wireFaults({heard(0, Accepted{}), heard(1, Outcome{}, 1, 2)}),
              ElementsAre(HasSubstr("of another daemon")));
  EXPECT_THAT(wireFaults({heard(0, SceneSnapshot{}), heard(1, SceneSnapshot{})}),
              ElementsAre(HasSubstr("a second scene")));
}

TEST(ClientFault, NeedsOneOutcomeAfterEventsWithoutAGap) {
  const std::string begin = R"({"sequence": 0, "type": "accepted"})"
                            "\n";
  const std::string end = R"({"sequence": 1, "type": "outcome"})"
                          "\n";
  const std::string restart = R"({"type": "restart"})"
                              "\n";
  EXPECT_EQ(clientFault(0, begin + end), "");
  EXPECT_EQ(clientFault(10, begin + restart + begin + end), "");
  EXPECT_EQ(clientFault(13, begin), "");
  EXPECT_THAT(clientFault(0, begin), HasSubstr("0 outcomes"));
  EXPECT_THAT(clientFault(13, begin + end), HasSubstr("1 outcomes"));
  EXPECT_THAT(clientFault(0, end), HasSubstr("event 1 after 0"));
  EXPECT_THAT(clientFault(0, begin + begin + end), HasSubstr("event 0 after 1"));
  EXPECT_EQ(clientFault(1, ""), "exit 1");
}

TEST(Faults, AreTheSameForTheSameSeed) {
  const auto faults = drawFaults(7, milliseconds(30'000));
  EXPECT_EQ(faults, drawFaults(7, milliseconds(30'000)));
  EXPECT_NE(faults, drawFaults(8, milliseconds(30'000)));
  EXPECT_GT(faults.size(), 20u);
  EXPECT_LT(faults.back().at, milliseconds(20'000));
  for (int kind = 0; kind < kFaultKinds; ++kind) {
    EXPECT_TRUE(std::any_of(faults.begin(), faults.end(), [&](const Fault& fault) {
      return fault.kind == static_cast<FaultKind>(kind);
    })) << kind;
  }
}

TEST(Shrunk, LeavesTheFaultsThatFailTogether) {
  const auto faults = drawFaults(3, milliseconds(30'000));
  const Fault a = faults[2], b = faults[faults.size() - 3];
  const auto holds = [](const std::vector<Fault>& all, const Fault& one) {
    return std::find(all.begin(), all.end(), one) != all.end();
  };
  int runs = 0;
  const auto least = shrunk(faults, [&](const std::vector<Fault>& fewer) {
    ++runs;
    return holds(fewer, a) && holds(fewer, b);
  });
  EXPECT_THAT(least, ElementsAre(a, b));
  EXPECT_LT(runs, 60);
}

TEST(Shrunk, LeavesNothingOfWhatAlwaysFails) {
  EXPECT_THAT(shrunk(drawFaults(3, milliseconds(9'000)), [](const auto&) { return true; }),
              IsEmpty());
}

}  // namespace
}  // namespace handover::test
