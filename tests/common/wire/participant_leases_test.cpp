// SPDX-License-Identifier: Apache-2.0
#include "wire/participant_leases.hpp"

#include "rtps_packets.hpp"

#include <gtest/gtest.h>

namespace handover::wire {
namespace {

using namespace std::chrono_literals;
using test::announcement;
using test::Bytes;
using test::datagram;
using test::heartbeat;

class ParticipantLeasesOverTime : public testing::Test {
 protected:
  /// `steps` of 100 ms, in each of which somebody else is heard.
  void listen(int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ += 100ms;
      (void)leases_.hear(datagram({heartbeat(1, 1)}), &discovery_, now_);
    }
  }

  ParticipantLeases::Heard announce(const test::Announcement& of) {
    return leases_.hear(announcement(of), &discovery_, now_);
  }

  std::size_t departed() { return leases_.departures(&discovery_, now_).size(); }

  const int discovery_ = 0, user_ = 0;
  ParticipantLeases leases_;
  ParticipantLeases::Clock::time_point now_{1h};
};

TEST_F(ParticipantLeasesOverTime, MakesAnnouncedLeasesEndless) {
  const auto heard = announce({.from = {1}, .lease = 3000ms});
  EXPECT_FALSE(heard.unendable);
  EXPECT_EQ(heard.endless, announcement({.from = {1}, .endless = true}));
  EXPECT_EQ(leases_.size(), 1u);
}

TEST_F(ParticipantLeasesOverTime, LeavesOtherDatagramsAlone) {
  const auto heard = leases_.hear(datagram({heartbeat(1, 1)}), &discovery_, now_);
  EXPECT_FALSE(heard.unendable);
  EXPECT_TRUE(heard.endless.empty());
  EXPECT_TRUE(leases_.hear(test::departure({1}), &discovery_, now_).endless.empty());
  EXPECT_EQ(leases_.size(), 0u);
}

TEST_F(ParticipantLeasesOverTime, LetsGoWhoWasSilentForItsLease) {
  announce({.from = {1}, .lease = 1000ms, .sample = 6});
  listen(10);
  EXPECT_EQ(departed(), 0u);
  listen(1);
  const auto gone = leases_.departures(&discovery_, now_);
  ASSERT_EQ(gone.size(), 1u);
  // What its own would be: from it, of its next sample.
  const auto heard = ParticipantLeases().hear(gone[0], &discovery_, now_);
  EXPECT_FALSE(heard.unendable);
  forEachSubmessage(gone[0], [](const Submessage& said, bool last) {
    EXPECT_TRUE(last);
    EXPECT_EQ(said.id, kDataId);
    EXPECT_EQ(said.from, GuidPrefix{1});
    EXPECT_EQ(said.sequenceAt(12), 7);
    EXPECT_EQ(payloadOf(said, kDataMembers), said.content.size());
  });
  EXPECT_EQ(departed(), 0u);
  EXPECT_EQ(leases_.size(), 0u);
}

TEST_F(ParticipantLeasesOverTime, KeepsWhoeverSaysAnything) {
  announce({.from = {1}, .lease = 1000ms});
  for (int i = 0; i < 50; ++i) {
    listen(1);
    (void)leases_.hear(datagram({heartbeat(1, 1)}, {1}), &user_, now_);
    EXPECT_EQ(departed(), 0u);
  }
}

TEST_F(ParticipantLeasesOverTime, LetsAllGoAfterASleepOfItsOwn) {
  announce({.from = {1}, .lease = 1000ms});
  announce({.from = {2}, .lease = 3000ms});
  now_ += 2s;
  EXPECT_EQ(departed(), 1u);
}

TEST_F(ParticipantLeasesOverTime, TellsWhereItWasAnnounced) {
  announce({.from = {1}, .lease = 100ms});
  listen(5);
  EXPECT_TRUE(leases_.departures(&user_, now_).empty());
  EXPECT_EQ(departed(), 1u);
}

TEST_F(ParticipantLeasesOverTime, RefusesWhoCouldNotBeLetGo) {
  EXPECT_TRUE(announce({.from = {1}, .with_lease = false}).unendable);
  EXPECT_TRUE(announce({.from = {1}, .announced = GuidPrefix{2}}).unendable);
  EXPECT_TRUE(announce({.from = {1}, .endpoints = 0x3e}).unendable);
  Bytes fragmented = announcement({.from = {1}});
  fragmented[20] = 0x16;
  EXPECT_TRUE(leases_.hear(fragmented, &discovery_, now_).unendable);
  Bytes unknown_form = announcement({.from = {1}});
  unknown_form[20 + 4 + 20 + 1] = 7;
  EXPECT_TRUE(leases_.hear(unknown_form, &discovery_, now_).unendable);
  EXPECT_EQ(leases_.size(), 0u);
}

TEST_F(ParticipantLeasesOverTime, LetsTheLongestSilentGoWhenThereAreTooMany) {
  for (int i = 0; i <= 4'096; ++i) {
    const auto low = static_cast<std::uint8_t>(i), high = static_cast<std::uint8_t>(i >> 8);
    announce({.from = {1, low, high}, .lease = 1h});
    now_ += 1ms;
  }
  EXPECT_EQ(leases_.size(), 4'096u);
  const auto gone = leases_.departures(&discovery_, now_);
  ASSERT_EQ(gone.size(), 1u);
  forEachSubmessage(gone[0], [](const Submessage& said, bool) {
    EXPECT_EQ(said.from, (GuidPrefix{1, 0, 0}));
  });
}

}  // namespace
}  // namespace handover::wire
