// SPDX-License-Identifier: Apache-2.0
#include "dds/kept_requests.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr RequestId kA{{1}}, kB{{2}}, kC{{3}}, kD{{4}};
constexpr wire::Guid kWriter{1}, kOtherWriter{2};

KeptRequests::Kept of(const std::string& client_id, std::size_t bytes = 1,
                      const wire::Guid& writer = kWriter) {
  return {.client_id = client_id, .writer = writer, .request = PlanRequest{}, .bytes = bytes};
}

TEST(KeptRequests, AreGivenOutAsTheyCame) {
  KeptRequests kept;
  kept.keep(kC, of("a"));
  kept.keep(kA, of("a"));
  kept.keep(kB, of("b"));
  EXPECT_THAT(kept.ids(), ElementsAre(kC, kA, kB));
  kept.keep(kC, of("a"));  // asked again
  EXPECT_THAT(kept.ids(), ElementsAre(kA, kB, kC));
}

TEST(KeptRequests, AreTakenOnce) {
  KeptRequests kept;
  kept.keep(kA, of("a"));
  kept.find(kA)->cancelled = CancelCause::kAsked;
  const auto taken = kept.take(kA);
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->cancelled, CancelCause::kAsked);
  EXPECT_FALSE(kept.take(kA));
  EXPECT_EQ(kept.find(kA), nullptr);
}

TEST(KeptRequests, BeyondTheirNumberCostTheClientThatHasMostItsOldest) {
  KeptRequests kept(3);
  kept.keep(kA, of("few"));
  kept.keep(kB, of("many"));
  kept.keep(kC, of("many"));
  kept.keep(kD, of("third"));
  EXPECT_THAT(kept.ids(), ElementsAre(kA, kC, kD));
}

TEST(KeptRequests, BeyondTheirBytesCostTheClientThatHasMostItsOldest) {
  KeptRequests kept(100, 1000);
  kept.keep(kA, of("small", 10));
  kept.keep(kB, of("large", 600));
  kept.keep(kC, of("large", 600));
  EXPECT_THAT(kept.ids(), ElementsAre(kA, kC));
  kept.forget(kC);
  kept.keep(kB, of("large", 900));  // the bytes of what is forgotten are free again
  EXPECT_THAT(kept.ids(), ElementsAre(kA, kB));
}

TEST(KeptRequests, OfALostWriterWaitForIt) {
  const KeptRequests::Clock::time_point start{};
  KeptRequests kept;
  kept.keep(kA, of("a"));
  kept.keep(kB, of("b", 1, kOtherWriter));
  kept.loseWriter(kWriter, start);
  EXPECT_THAT(kept.ids(), ElementsAre(kB));
  kept.forgetLost(start);
  kept.regainWriter(kWriter);
  EXPECT_THAT(kept.ids(), ElementsAre(kA, kB));
  kept.forgetLost(start + 1h);
  EXPECT_EQ(kept.size(), 2u);
}

TEST(KeptRequests, OfAWriterThatStaysAwayAreForgotten) {
  const KeptRequests::Clock::time_point start{};
  KeptRequests kept;
  kept.keep(kA, of("a"));
  kept.loseWriter(kWriter, start);
  kept.loseWriter(kOtherWriter, start);
  kept.keep(kB, of("b", 1, kOtherWriter));  // handed back after the loss
  EXPECT_THAT(kept.ids(), IsEmpty());
  EXPECT_EQ(kept.size(), 2u);
  kept.forgetLost(start + 1ms);
  EXPECT_EQ(kept.size(), 0u);
}

}  // namespace
}  // namespace handover
