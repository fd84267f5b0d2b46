// SPDX-License-Identifier: Apache-2.0
#include "wire/packet_guard.hpp"

#include "rtps_packets.hpp"

#include <gtest/gtest.h>

namespace handover::wire {
namespace {

using test::Bytes;
using test::data;
using test::datagram;
using test::fragment;
using test::gap;
using test::heartbeat;
using test::statistics;
using test::submessage;

std::optional<PacketFault> fault(const std::vector<Bytes>& submessages) {
  return packetFault(datagram(submessages));
}

const Bytes kTimestamp = submessage(0x09, Bytes(8));

TEST(PacketGuard, LetsOrdinaryDatagramsPass) {
  EXPECT_EQ(fault({}), std::nullopt);
  EXPECT_EQ(fault({kTimestamp, data(Bytes(24)), heartbeat(1, 1), statistics()}), std::nullopt);
  EXPECT_EQ(fault({heartbeat(1, 0), statistics()}), std::nullopt);  // nothing written yet
  EXPECT_EQ(fault({gap(3, 3 + 65'536)}), std::nullopt);
  EXPECT_EQ(fault({gap(7, 7)}), std::nullopt);
  EXPECT_EQ(fault({heartbeat(1 << 24, 1ll << 40)}), std::nullopt);
  EXPECT_EQ(fault({data(Bytes(24), {0x70, 0, 4, 0, 1, 2, 3, 4, 1, 0, 0, 0})}), std::nullopt);
  EXPECT_EQ(fault({data({})}), std::nullopt);
  EXPECT_EQ(fault({fragment({})}), std::nullopt);
  EXPECT_EQ(fault({fragment({.first = 2, .count = 2, .payload = 150})}), std::nullopt);
}

TEST(PacketGuard, LetsPassWhatIsNotForIt) {
  EXPECT_EQ(packetFault({}), std::nullopt);
  EXPECT_EQ(packetFault(Bytes(19)), std::nullopt);
  EXPECT_EQ(packetFault(Bytes(100, 0xff)), std::nullopt);
  const Bytes encrypted = submessage(0x31, Bytes(20)), body = submessage(0x30, Bytes(99));
  EXPECT_EQ(fault({encrypted, body}), std::nullopt);
}

TEST(PacketGuard, HoldsLengthsAgainstTheDatagram) {
  EXPECT_EQ(fault({submessage(0x15, Bytes(24), 4, 25)}), PacketFault::kLength);
  EXPECT_EQ(fault({kTimestamp, {0x15, 1, 0}}), PacketFault::kLength);
  for (const Bytes& whole : {gap(1, 2), heartbeat(1, 2), data({}), fragment({})}) {
    const Bytes content(whole.begin() + 4, whole.begin() + 4 + 19);
    EXPECT_EQ(fault({submessage(whole[0], content)}), PacketFault::kLength);
  }
  // A short gap: the library would read on in what follows.
  EXPECT_EQ(fault({submessage(0x08, Bytes(8)), kTimestamp}), PacketFault::kLength);
}

TEST(PacketGuard, TakesALengthOfZeroForTheRest) {
  Bytes endless = gap(1, 1ll << 52);
  endless[2] = endless[3] = 0;
  EXPECT_EQ(fault({endless}), PacketFault::kGap);
  // Of a timestamp (none) and of padding it is what it says.
  EXPECT_EQ(fault({submessage(0x09, {}, 2), submessage(0x01, {}), gap(1, 1ll << 52)}),
            PacketFault::kGap);
}

TEST(PacketGuard, StopsStatisticsThatAreNotLast) {
  EXPECT_EQ(fault({statistics(), kTimestamp}), PacketFault::kStatistics);
  EXPECT_EQ(fault({statistics(), Bytes(1)}), PacketFault::kStatistics);
  EXPECT_EQ(packetFault(datagram({statistics(), kTimestamp}, {}, {1, 16})), std::nullopt);
}

TEST(PacketGuard, StopsGapsThatWouldBeWalkedForLong) {
  EXPECT_EQ(fault({gap(1, 1ll << 52)}), PacketFault::kGap);
  EXPECT_EQ(fault({gap(3, 3 + 65'537)}), PacketFault::kGap);
  EXPECT_EQ(fault({gap(1, 0)}), PacketFault::kGap);
  EXPECT_EQ(fault({gap(1, -5)}), PacketFault::kGap);
  EXPECT_EQ(fault({gap(0, 5)}), PacketFault::kGap);
  EXPECT_EQ(fault({gap(INT64_MIN, INT64_MAX)}), PacketFault::kGap);
  EXPECT_EQ(fault({kTimestamp, data(Bytes(4)), gap(1, 1ll << 52), statistics()}),
            PacketFault::kGap);
}

TEST(PacketGuard, ReadsBigEndianToo) {
  Bytes big{0x08, 0, 0, 28};
  big.resize(12);
  test::append(big, {0, 0, 0, 0, 0, 0, 0, 1});  // first
  test::append(big, {0, 0x10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(fault({big}), PacketFault::kGap);
  big[4 + 8 + 8 + 1] = 0;
  big[4 + 8 + 8 + 7] = 2;
  EXPECT_EQ(fault({big}), std::nullopt);
}

TEST(PacketGuard, StopsHeartbeatsOfImpossibleSamples) {
  EXPECT_EQ(fault({heartbeat(0, -1)}), PacketFault::kHeartbeat);
  EXPECT_EQ(fault({heartbeat(-1, 4)}), PacketFault::kHeartbeat);
  EXPECT_EQ(fault({heartbeat((1 << 24) + 1, 1ll << 40)}), PacketFault::kHeartbeat);
}

/// A guard at a time of its own, and a writer's heartbeats of first sample 1 to it.
class PacketGuardOverTime : public testing::Test {
 protected:
  std::optional<PacketFault> heard(std::int64_t first, const test::EntityId& writer = {0, 0, 1, 2},
                                   const std::array<std::uint8_t, 12>& from = {}) {
    return guard.fault(datagram({heartbeat(first, first, 1, writer)}, from), now);
  }

  PacketGuard guard;
  PacketGuard::Clock::time_point now{};
};

TEST_F(PacketGuardOverTime, TakesAWritersFirstHeartbeatAsItIs) {
  EXPECT_EQ(heard(1 << 24), std::nullopt);
  EXPECT_EQ(heard((1 << 24) - 5), std::nullopt);  // overtaken by the other
  EXPECT_EQ(heard(1 << 23, {0, 0, 2, 2}), std::nullopt);
  EXPECT_EQ(heard((1 << 24) + 1, {0, 0, 3, 2}), PacketFault::kHeartbeat);
}

TEST_F(PacketGuardOverTime, StopsHeartbeatsFarBeyondTheirWritersLast) {
  EXPECT_EQ(heard(1), std::nullopt);
  EXPECT_EQ(heard(16'386), PacketFault::kHeartbeat);
  EXPECT_EQ(heard(1 << 23), PacketFault::kHeartbeat);
  EXPECT_EQ(heard(16'385), std::nullopt);
  EXPECT_EQ(heard(2 * 16'384), std::nullopt);
  EXPECT_EQ(heard(1 << 23, {0, 0, 1, 2}, {7}), std::nullopt);  // another participant's
}

TEST_F(PacketGuardOverTime, LetsAWriterBeHeardAgainAfterALongSilence) {
  EXPECT_EQ(heard(1), std::nullopt);
  now += std::chrono::hours(1);
  EXPECT_EQ(heard(3'700'000), PacketFault::kHeartbeat);
  EXPECT_EQ(heard(3'600'000), std::nullopt);
}

TEST_F(PacketGuardOverTime, KnowsInWhoseNameItIsSaid) {
  const Bytes in_anothers_name = submessage(0x0c, Bytes(20, 9));
  EXPECT_EQ(guard.fault(datagram({in_anothers_name, heartbeat(1, 1)}), now), std::nullopt);
  EXPECT_EQ(guard.fault(datagram({heartbeat(1 << 20, 1 << 20)}), now), std::nullopt);
  EXPECT_EQ(guard.fault(datagram({in_anothers_name, heartbeat(1 << 20, 1 << 20)}), now),
            PacketFault::kHeartbeat);
}

TEST_F(PacketGuardOverTime, KeepsABoundedNumberOfWriters) {
  for (int i = 0; i < 10'000; ++i) {
    const auto low = static_cast<std::uint8_t>(i), high = static_cast<std::uint8_t>(i >> 8);
    EXPECT_EQ(heard(1, {high, low, 1, 2}), std::nullopt);
    ASSERT_LE(guard.size(), 4'096u);
  }
  EXPECT_GT(guard.size(), 0u);
}

TEST(PacketGuard, StopsSamplesWithoutASuccessor) {
  EXPECT_EQ(fault({heartbeat(1, INT64_MAX)}), PacketFault::kSequence);
  EXPECT_EQ(fault({heartbeat(1, (1ll << 48) + 1)}), PacketFault::kSequence);
  EXPECT_EQ(fault({heartbeat(1, 1ll << 48)}), std::nullopt);
  EXPECT_EQ(fault({gap(INT64_MAX - 1, INT64_MAX)}), PacketFault::kSequence);
  Bytes far = data(Bytes(4));
  std::fill_n(far.begin() + 4 + 12, 8, 0xff);  // the sample's number
  far[4 + 12 + 3] = 0x7f;
  EXPECT_EQ(fault({far}), PacketFault::kSequence);
  Bytes fragments = fragment({});
  std::copy_n(far.begin() + 4 + 12, 8, fragments.begin() + 4 + 12);
  EXPECT_EQ(fault({fragments}), PacketFault::kSequence);
  Bytes fragments_there = submessage(0x13, Bytes(24));
  std::copy_n(far.begin() + 4 + 12, 8, fragments_there.begin() + 4 + 8);
  EXPECT_EQ(fault({fragments_there}), PacketFault::kSequence);
}

TEST(PacketGuard, StopsDataWhosePayloadBeginsBeyondIt) {
  EXPECT_EQ(fault({data(Bytes(8), {}, 100), kTimestamp, Bytes(200)}), PacketFault::kData);
  EXPECT_EQ(fault({data(Bytes(8), {}, 4)}), PacketFault::kData);
  EXPECT_EQ(fault({data({}, {0x70, 0, 0xf0, 0xff})}), PacketFault::kData);
  EXPECT_EQ(fault({data({}, {0x70, 0, 4, 0, 1, 2, 3, 4})}), PacketFault::kData);  // no end
}

TEST(PacketGuard, StopsFragmentsThatDoNotFitTheirSample) {
  EXPECT_EQ(fault({fragment({.first = 0})}), PacketFault::kFragment);
  EXPECT_EQ(fault({fragment({.count = 0})}), PacketFault::kFragment);
  EXPECT_EQ(fault({fragment({.size = 3})}), PacketFault::kFragment);
  EXPECT_EQ(fault({fragment({.sample = 1u << 31})}), PacketFault::kFragment);
  EXPECT_EQ(fault({fragment({.first = 4})}), PacketFault::kFragment);
  EXPECT_EQ(fault({fragment({.first = UINT32_MAX, .count = UINT16_MAX})}), PacketFault::kFragment);
  EXPECT_EQ(fault({fragment({.first = 2, .count = 2, .payload = 149})}), PacketFault::kFragment);
}

}  // namespace
}  // namespace handover::wire
