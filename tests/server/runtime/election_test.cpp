// SPDX-License-Identifier: Apache-2.0
// Daemons that elect a leader, on a clock of the test's.
#include "runtime/election.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <set>

namespace handover {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::SizeIs;
using Time = Election::Clock::time_point;

constexpr auto kStep = 25ms;
const std::string kCell = "butler";

DaemonId idOf(std::uint8_t number) { return {number}; }

/// Daemons on one wire that delivers at once, but to those that sleep: they hear all of it when
/// they wake, after they have had a turn. One that slept for 3 s and the others have lost each
/// other: for a while after that they hear nothing of each other.
class World {
 public:
  struct Daemon {
    explicit Daemon(const DaemonId& id) : election(id, {}) {}

    Election election;
    bool alive = true, asleep = false, announced = true;
    Time asleep_since, lost_until;
    std::vector<Claim> inbox;
    std::optional<Time> leads_until;
    std::vector<std::string> won, lost;
  };

  explicit World(int count) {
    for (int i = 0; i < count; ++i) join();
  }

  Daemon& join() {
    const auto id = idOf(static_cast<std::uint8_t>(daemons.size() + 1));
    daemons.push_back(std::make_unique<Daemon>(id));
    daemons.back()->election.stand({kCell}, now);
    return *daemons.back();
  }

  Daemon& operator[](std::size_t i) { return *daemons[i]; }

  void run(std::chrono::milliseconds time) {
    for (const Time until = now + time; now < until; now += kStep) step();
  }

  std::vector<std::size_t> leaders() const {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < daemons.size(); ++i) {
      const Daemon& each = *daemons[i];
      if (each.alive && each.election.roleOf(kCell) == CellRole::kLeader) all.push_back(i);
    }
    return all;
  }

  void sleep(std::size_t i) {
    daemons[i]->asleep = true;
    daemons[i]->asleep_since = now;
  }

  void wake(std::size_t i) {
    Daemon& self = *daemons[i];
    self.asleep = false;
    if (now - self.asleep_since >= 3s) self.lost_until = now + 2500ms;
  }

  /// Those that may send an outcome now.
  int mayAnswer() const {
    int count = 0;
    for (const auto& each : daemons) {
      if (!each->alive || each->asleep) continue;
      count += each->election.roleOf(kCell) == CellRole::kLeader && each->leads_until > now ? 1 : 0;
    }
    return count;
  }

  void end(std::size_t i) {
    Daemon& ending = *daemons[i];
    ending.alive = ending.announced = false;
    const Claim claim{cellKey(kCell), idOf(static_cast<std::uint8_t>(i + 1)),
                      ending.election.epochOf(kCell)};
    for (const auto& each : daemons) each->election.ended(claim, now);
  }

  Time now = Time() + 1h;
  std::vector<std::unique_ptr<Daemon>> daemons;

 private:
  void step() {
    for (std::size_t i = 0; i < daemons.size(); ++i) turn(i);
    for (const auto& each : daemons) {
      if (each->asleep || !each->alive) continue;
      if (isLost(*each)) each->inbox.clear();
      for (const Claim& claim : each->inbox) each->election.heard(claim, now);
      each->inbox.clear();
    }
  }

  void turn(std::size_t i) {
    Daemon& self = *daemons[i];
    if (!self.alive || self.asleep) return;
    const bool lost = isLost(self);
    const auto turn = self.election.turn(now, [&](const std::string&) { return peersOf(i); });
    self.leads_until = turn.leads_until;
    self.won.insert(self.won.end(), turn.won.begin(), turn.won.end());
    self.lost.insert(self.lost.end(), turn.lost.begin(), turn.lost.end());
    if (lost) return;
    for (const Claim& claim : turn.claims) {
      for (const auto& each : daemons) each->inbox.push_back(claim);
    }
  }

  bool isLost(const Daemon& daemon) const { return now < daemon.lost_until; }

  /// A daemon that was killed or stopped is still announced.
  std::vector<DaemonId> peersOf(std::size_t self) const {
    std::vector<DaemonId> peers;
    if (isLost(*daemons[self])) return peers;
    for (std::size_t i = 0; i < daemons.size(); ++i) {
      if (i != self && daemons[i]->announced && !isLost(*daemons[i]))
        peers.push_back(idOf(static_cast<std::uint8_t>(i + 1)));
    }
    return peers;
  }
};

TEST(CellKeys, AreTheSameEverywhere) {
  // XXH128 of "butler" by `xxh128sum`.
  const CellKey key = cellKey("butler");
  EXPECT_EQ(RequestId{key}.hex(), "03b30a5bbca3ec0b894938413f319175");
  EXPECT_NE(cellKey("butler_left"), key);
}

TEST(AnElection, MakesALoneDaemonTheLeaderOnceItHasListened) {
  World world(1);
  world.run(475ms);
  EXPECT_EQ(world[0].election.roleOf(kCell), CellRole::kUndecided);
  world.run(100ms);
  EXPECT_EQ(world[0].election.roleOf(kCell), CellRole::kLeader);
  EXPECT_EQ(world[0].election.epochOf(kCell), 1u);
  EXPECT_EQ(world[0].election.roleOf("stool"), CellRole::kUndecided);
}

TEST(AnElection, MakesOneOfSeveralThatStartTogetherTheLeader) {
  World world(4);
  world.run(2s);
  EXPECT_THAT(world.leaders(), ElementsAre(0));
  for (int i = 1; i < 4; ++i) {
    EXPECT_EQ(world[i].election.roleOf(kCell), CellRole::kStandby);
    EXPECT_EQ(world[i].election.epochOf(kCell), 1u);
    EXPECT_TRUE(world[i].won.empty());
  }
}

TEST(AnElection, LeavesTheLeaderToANewcomerOfLowerId) {
  World world(0);
  world.daemons.push_back(std::make_unique<World::Daemon>(idOf(9)));
  world[0].election.stand({kCell}, world.now);
  world.run(1s);
  world.join();
  world.run(2s);
  EXPECT_THAT(world.leaders(), ElementsAre(0));
}

TEST(AnElection, FollowsAKilledLeaderWithinTheLeaseWithTheNextEpoch) {
  World world(3);
  world.run(2s);
  world[0].alive = false;
  world.run(600ms);
  EXPECT_THAT(world.leaders(), ElementsAre(1));
  EXPECT_EQ(world[1].election.epochOf(kCell), 2u);
  world.run(2s);
  EXPECT_THAT(world.leaders(), ElementsAre(1));
  EXPECT_EQ(world[2].election.epochOf(kCell), 2u);
  world[1].alive = false;
  world.run(1s);  // the first one's turn comes first: nobody knows that it is gone
  EXPECT_THAT(world.leaders(), ElementsAre(2));
  EXPECT_EQ(world[2].election.epochOf(kCell), 3u);
}

TEST(AnElection, FollowsALeaderThatEndsAtOnce) {
  World world(2);
  world.run(2s);
  world.end(0);
  world.run(200ms);
  EXPECT_THAT(world.leaders(), ElementsAre(1));
}

TEST(AnElection, HasAStoppedLeaderStepBackBeforeItAnswers) {
  World world(2);
  world.run(2s);
  world.sleep(0);
  world.run(2s);
  ASSERT_EQ(world[1].election.roleOf(kCell), CellRole::kLeader);
  world.wake(0);
  for (int i = 0; i < 40; ++i) {
    world.run(kStep);
    EXPECT_LE(world.mayAnswer(), 1);
  }
  EXPECT_THAT(world.leaders(), ElementsAre(1));
  EXPECT_THAT(world[0].lost, ElementsAre(kCell));
  EXPECT_EQ(world[0].election.roleOf(kCell), CellRole::kStandby);
}

TEST(AnElection, HasALeaderThatAllHaveLostStepBackBeforeItAnswers) {
  World world(2);
  world.run(2s);
  world.sleep(0);
  world.run(5s);
  world.wake(0);
  for (int i = 0; i < 160; ++i) {
    world.run(kStep);
    EXPECT_EQ(world.mayAnswer(), 1);
  }
  EXPECT_THAT(world.leaders(), ElementsAre(1));
  EXPECT_TRUE(world[1].lost.empty());
}

TEST(AnElection, HasALeaderGoOnThatSleptAndWasNotFollowed) {
  World world(1);
  world.run(2s);
  world.sleep(0);
  world.run(2s);
  world.wake(0);
  world.run(2 * kStep);
  EXPECT_EQ(world.mayAnswer(), 1);
  world.sleep(0);
  world.run(8s);
  world.wake(0);
  world.run(2900ms);  // somebody may have come and followed it
  EXPECT_EQ(world.mayAnswer(), 0);
  world.run(200ms);
  EXPECT_EQ(world.mayAnswer(), 1);
  EXPECT_EQ(world[0].election.epochOf(kCell), 1u);
  EXPECT_TRUE(world[0].lost.empty());
}

TEST(AnElection, KeepsAStandbyThatSleptFromTakingOver) {
  for (const auto time : {1s, 4s}) {
    World world(2);
    world.run(2s);
    world.sleep(1);
    world.run(time);
    world.wake(1);
    world.run(5s);
    EXPECT_THAT(world.leaders(), ElementsAre(0));
    EXPECT_TRUE(world[1].won.empty());
    EXPECT_TRUE(world[0].lost.empty());
  }
}

TEST(AnElection, KeepsItsLeaderWhenAllSleep) {
  World world(2);
  world.run(2s);
  for (const std::size_t i : {0, 1}) world.sleep(i);
  world.run(10s);
  for (const std::size_t i : {0, 1}) world.wake(i);
  world.run(5s);
  EXPECT_THAT(world.leaders(), ElementsAre(0));
  EXPECT_TRUE(world[1].won.empty());
}

TEST(AnElection, SettlesTwoLeadersOfOneEpoch) {
  const Claim of_low{cellKey(kCell), idOf(1), 1}, of_high{cellKey(kCell), idOf(2), 1};
  const auto none = [](const std::string&) { return std::vector<DaemonId>{}; };
  Time now = Time() + 1h;
  Election low(idOf(1), {}), high(idOf(2), {});
  for (Election* each : {&low, &high}) {
    each->stand({kCell}, now);
    EXPECT_THAT(each->turn(now + 500ms, none).claims, SizeIs(1));
    EXPECT_THAT(each->turn(now + 550ms, none).won, ElementsAre(kCell));
  }
  // Each hears the other, or (the middleware shows the stronger only) one of them does.
  high.heard(of_low, now + 560ms);
  low.heard(of_high, now + 560ms);
  EXPECT_THAT(high.turn(now + 575ms, none).lost, ElementsAre(kCell));
  const auto turn = low.turn(now + 575ms, none);
  EXPECT_THAT(turn.claims, ElementsAre(Claim{cellKey(kCell), idOf(1), 2}));
  EXPECT_EQ(low.roleOf(kCell), CellRole::kLeader);
}

TEST(AnElection, GivesUpCellsThatAreServedNoMore) {
  World world(1);
  world.run(1s);
  world[0].election.stand({"stool"}, world.now);
  EXPECT_EQ(world[0].election.roleOf(kCell), CellRole::kUndecided);
  world.run(1s);
  EXPECT_EQ(world[0].election.roleOf("stool"), CellRole::kLeader);
}

TEST(AnElection, NeverLetsTwoAnswerWhoeverSleepsOrEnds) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    World world(3);
    world.run(2s);
    for (int event = 0; event < 20; ++event) {
      const auto chosen = random() % world.daemons.size();
      auto& daemon = world[chosen];
      if (daemon.alive) daemon.asleep ? world.wake(chosen) : world.sleep(chosen);
      if (random() % 10 == 0 && world.daemons.size() < 8) world.join();
      if (random() % 10 == 0) world[random() % world.daemons.size()].alive = false;
      for (unsigned i = random() % 80; i > 0; --i) {
        world.run(kStep);
        ASSERT_LE(world.mayAnswer(), 1) << "seed " << seed << ", event " << event;
      }
    }
    for (std::size_t i = 0; i < world.daemons.size(); ++i) {
      if (world[i].asleep) world.wake(i);
    }
    world.join();
    world.run(8s);
    EXPECT_EQ(world.leaders().size(), 1u) << "seed " << seed;
  }
}

}  // namespace
}  // namespace handover
