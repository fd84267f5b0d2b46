// SPDX-License-Identifier: Apache-2.0
#include "runtime/fair_queue.hpp"

#include "runtime/client_accounts.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// What one worker runs, one after the other, each for as long as its client's take.
std::vector<std::string> served(FairQueue<std::string>& queue, std::size_t count,
                                const std::map<char, double>& seconds) {
  std::vector<std::string> items;
  while (items.size() < count && !queue.empty()) {
    items.push_back(queue.pop());
    queue.finished(std::string(1, items.back()[0]), seconds.at(items.back()[0]));
  }
  return items;
}

TEST(FairQueue, ServesOneClientInTheOrderOfItsPlaces) {
  FairQueue<std::string> queue;
  for (const int place : {3, 1, 2}) queue.push("a", place, "a" + std::to_string(place));
  EXPECT_EQ(queue.size(), 3u);
  EXPECT_THAT(served(queue, 9, {{'a', 1}}), ElementsAre("a1", "a2", "a3"));
}

TEST(FairQueue, SharesTimeNotTurns) {
  FairQueue<std::string> queue;
  for (int i = 0; i < 9; ++i) {
    queue.push("a", i, "a" + std::to_string(i));
    queue.push("b", i, "b" + std::to_string(i));
  }
  const auto order = served(queue, 8, {{'a', 3}, {'b', 1}});
  EXPECT_EQ(std::count_if(order.begin(), order.end(), [](const auto& i) { return i[0] == 'a'; }),
            2);
}

TEST(FairQueue, WhoComesLaterHasNoDebtAndNoCredit) {
  FairQueue<std::string> queue;
  for (int i = 0; i < 9; ++i) queue.push("a", i, "a");
  served(queue, 5, {{'a', 100}});
  for (int i = 0; i < 9; ++i) queue.push("b", i, "b");
  EXPECT_THAT(served(queue, 4, {{'a', 1}, {'b', 1}}), ElementsAre("b", "a", "b", "a"));
}

TEST(FairQueue, LetsTheClientWithFewerRunningGoFirst) {
  FairQueue<std::string> queue;
  for (int i = 0; i < 3; ++i) queue.push("a", i, "a");
  queue.push("b", 0, "b");
  EXPECT_EQ(queue.pop(), "a");
  EXPECT_EQ(queue.pop(), "b");
  queue.finished("b", 5);
  queue.push("b", 1, "b");
  EXPECT_EQ(queue.pop(), "b");
}

TEST(FairQueue, TellsHowManyGoBeforeANewOne) {
  FairQueue<std::string> queue;
  EXPECT_EQ(queue.ahead("b"), 0u);
  for (int i = 0; i < 9; ++i) queue.push("a", i, "a");
  EXPECT_EQ(queue.ahead("a"), 9u);
  for (int i = 0; i < 4; ++i) {
    // What is said is what is served.
    FairQueue<std::string> told = queue;
    const std::size_t ahead = told.ahead("b");
    told.push("b", 100, "new");
    std::vector<std::string> order;
    while (!told.empty()) {
      order.push_back(told.pop());
      told.finished(order.back() == "a" ? "a" : "b", 1);
    }
    EXPECT_EQ(order.at(ahead), "new") << i;
    queue.push("b", i, "b");
  }
}

TEST(FairQueue, GivesOutWhatIsAskedFor) {
  FairQueue<std::string> queue;
  queue.push("a", 0, "x");
  queue.push("a", 1, "y");
  queue.push("b", 0, "x");
  EXPECT_THAT(queue.extract([](const std::string& item) { return item == "x"; }),
              ElementsAre("x", "x"));
  EXPECT_EQ(queue.size(), 1u);
  EXPECT_EQ(queue.pop(), "y");
  EXPECT_TRUE(queue.empty());
}

TEST(ClientAccounts, RefuseWhoUsedItsShareForAnHour) {
  ClientAccounts accounts({.cpu_s = 10, .cache_bytes = 5 << 20});
  const ClientAccounts::Clock::time_point start{};
  accounts.charge("a", 9, 0, start);
  EXPECT_EQ(accounts.refusal("a", start), "");
  accounts.charge("a", 1, 0, start);
  EXPECT_THAT(accounts.refusal("a", start), HasSubstr("10.0 s of planning"));
  accounts.charge("b", 0, 5 << 20, start);
  EXPECT_THAT(accounts.refusal("b", start), HasSubstr("5 MiB of maps"));
  EXPECT_EQ(accounts.refusal("c", start), "");
  EXPECT_EQ(accounts.refusal("a", start + std::chrono::hours(1)), "");
  accounts.charge("a", 1, 0, start + std::chrono::hours(1));
  EXPECT_EQ(accounts.refusal("a", start + std::chrono::hours(1)), "");
}

TEST(ClientAccounts, WithoutLimitsRefuseNobody) {
  ClientAccounts accounts({});
  accounts.charge("a", 1e9, std::uint64_t{1} << 60, {});
  EXPECT_EQ(accounts.refusal("a", {}), "");
}

}  // namespace
}  // namespace handover
