// SPDX-License-Identifier: Apache-2.0
#include "core/task/stages.hpp"

#include <gmock/gmock.h>

#include <string>

namespace handover {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// "0 reach", ...
std::vector<std::string> listOf(const Transport& transport) {
  std::vector<std::string> names;
  for (const TaskStage& stage : makeStages(transport)) {
    names.push_back(std::to_string(stage.holder) + " " + toString(stage.action));
  }
  return names;
}

constexpr Transport kHandover{2, false, TransportEnd::kRelease};

/// "hands 0 1, start" of what a stage allows.
std::string contactsText(const AllowedContacts& contacts) {
  std::string text;
  contacts.hands.forEach([&](std::size_t holder) { text += std::to_string(holder) + " "; });
  if (contacts.start_rest) text += "start ";
  if (contacts.goal_rest) text += "goal ";
  if (!text.empty()) text.pop_back();
  return text;
}

std::vector<std::string> contactsOf(const Transport& transport) {
  std::vector<std::string> texts;
  for (const TaskStage& stage : makeStages(transport)) {
    texts.push_back(contactsText(allowedContacts(stage)));
  }
  return texts;
}

std::vector<std::string> holdersBefore(const Transport& transport) {
  std::vector<std::string> texts;
  for (const TaskStage& stage : makeStages(transport)) {
    texts.push_back(contactsText({stage.before.holders, false, false}));
  }
  return texts;
}

std::vector<std::string> precedences(const Transport& transport, const std::vector<int>& arms) {
  const std::vector<TaskStage> stages = makeStages(transport);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    std::string text;
    for (const Precedence& it : precedenceOf(stages, i, arms)) {
      text += std::to_string(it.stage) + (it.progress == Progress::kClear ? "c " : " ");
    }
    if (!text.empty()) text.pop_back();
    texts.push_back(text);
  }
  return texts;
}

TEST(Stages, OfThePapersHandoverAreSixteen) {
  EXPECT_THAT(listOf(kHandover),
              ElementsAre("0 reach", "0 approach", "0 grasp", "0 lift", "0 carry", "1 reach",
                          "1 approach", "1 grasp", "0 release", "0 retreat", "0 home", "1 carry",
                          "1 place", "1 release", "1 retreat", "1 home"));
}

TEST(Stages, OfOneHolderArePickAndPlace) {
  EXPECT_THAT(listOf({1, false, TransportEnd::kRelease}),
              ElementsAre("0 reach", "0 approach", "0 grasp", "0 lift", "0 carry", "0 place",
                          "0 release", "0 retreat", "0 home"));
}

TEST(Stages, OfThreeHoldersHaveTwoHandovers) {
  EXPECT_THAT(
      listOf({3, false, TransportEnd::kRelease}),
      ElementsAre("0 reach", "0 approach", "0 grasp", "0 lift", "0 carry",                 //
                  "1 reach", "1 approach", "1 grasp", "0 release", "0 retreat", "0 home",  //
                  "1 carry",                                                               //
                  "2 reach", "2 approach", "2 grasp", "1 release", "1 retreat", "1 home",  //
                  "2 carry", "2 place", "2 release", "2 retreat", "2 home"));
}

TEST(Stages, OfFourHoldersThatEndInTheHand) {
  EXPECT_THAT(
      listOf({4, false, TransportEnd::kHold}),
      ElementsAre("0 reach", "0 approach", "0 grasp", "0 lift", "0 carry",                 //
                  "1 reach", "1 approach", "1 grasp", "0 release", "0 retreat", "0 home",  //
                  "1 carry",                                                               //
                  "2 reach", "2 approach", "2 grasp", "1 release", "1 retreat", "1 home",  //
                  "2 carry",                                                               //
                  "3 reach", "3 approach", "3 grasp", "2 release", "2 retreat", "2 home",  //
                  "3 carry"));
}

TEST(Stages, OfAnObjectInHandBeginWithItsCarry) {
  EXPECT_THAT(listOf({1, true, TransportEnd::kHold}), ElementsAre("0 carry"));
  EXPECT_THAT(listOf({2, true, TransportEnd::kHold}),
              ElementsAre("0 carry", "1 reach", "1 approach", "1 grasp", "0 release", "0 retreat",
                          "0 home", "1 carry"));
}

TEST(Stages, RefuseChainsOfNobody) {
  EXPECT_THROW(makeStages({0, false, TransportEnd::kRelease}), std::invalid_argument);
  EXPECT_THROW(makeStages({HolderSet::kMost + 1, false, TransportEnd::kRelease}),
               std::invalid_argument);
}

TEST(Stages, HoldFromTheEndOfAGraspToTheEndOfARelease) {
  EXPECT_THAT(holdersBefore(kHandover), ElementsAre("", "", "", "0", "0", "0", "0", "0", "0 1", "1",
                                                    "1", "1", "1", "1", "", ""));
}

TEST(AllowedContacts, OfThePapersHandoverFollowFromTheObjectsState) {
  EXPECT_THAT(contactsOf(kHandover), ElementsAre("", "", "0 start", "0 start", "0",  //
                                                 "0", "0", "0 1", "0 1", "1", "1",   //
                                                 "1", "1 goal", "1 goal", "", ""));
}

TEST(AllowedContacts, OfAPickAndPlaceNameBothRests) {
  EXPECT_THAT(contactsOf({1, false, TransportEnd::kRelease}),
              ElementsAre("", "", "0 start", "0 start", "0", "0 goal", "0 goal", "", ""));
}

TEST(AllowedContacts, OfAnObjectInHandNeverNameTheStart) {
  EXPECT_THAT(contactsOf({2, true, TransportEnd::kHold}),
              ElementsAre("0", "0", "0", "0 1", "0 1", "1", "1", "1"));
}

TEST(AllowedContacts, LastForTheFirstPartOfARetreat) {
  const std::vector<TaskStage> stages = makeStages(kHandover);
  EXPECT_EQ(contactsText(departingContacts(stages[9])), "0 1");
  EXPECT_EQ(contactsText(departingContacts(stages[14])), "1");
  EXPECT_EQ(departingContacts(stages[10]), allowedContacts(stages[10]));
}

TEST(Precedence, OfThePapersHandover) {
  EXPECT_THAT(precedences(kHandover, {0, 1}), ElementsAre("", "0", "1", "2", "3",           //
                                                          "", "5", "4 6", "4 7", "8", "9",  //
                                                          "7 9c", "11", "12", "13", "14"));
}

TEST(Precedence, LetsAnArmThatComesAgainFinishFirst) {
  // Right, left, right: the right arm reaches again only when it is home.
  const auto edges = precedences({3, false, TransportEnd::kHold}, {0, 1, 0});
  const auto stages = listOf({3, false, TransportEnd::kHold});
  EXPECT_EQ(stages[10], "0 home");
  EXPECT_EQ(stages[12], "2 reach");
  EXPECT_EQ(edges[12], "10");
}

TEST(Precedence, OfTheLastReleaseKnowsNobodyElsesWayHome) {
  const std::vector<TaskStage> stages = makeStages(kHandover);
  EXPECT_THAT(precedenceOf(stages, 13, {0, 1}), ElementsAre(Precedence{12, Progress::kEnd}));
}

TEST(Joinable, AreTheFourPairsOfTheContract) {
  const std::vector<TaskStage> stages = makeStages(kHandover);
  std::vector<std::string> joined;
  for (std::size_t i = 1; i < stages.size(); ++i) {
    if (!joinable(stages[i - 1], stages[i])) continue;
    joined.push_back(std::string(toString(stages[i - 1].action)) + "+" +
                     toString(stages[i].action));
  }
  EXPECT_THAT(joined, ElementsAre("reach+approach", "lift+carry", "reach+approach", "retreat+home",
                                  "carry+place", "retreat+home"));
}

}  // namespace
}  // namespace handover
