// SPDX-License-Identifier: Apache-2.0
#include <handover/common/request_id.hpp>

#include <gtest/gtest.h>

namespace handover {
namespace {

TEST(RequestId, HexRoundTrips) {
  const RequestId id = RequestId::random();
  EXPECT_EQ(id.hex().size(), 32u);
  EXPECT_EQ(RequestId::fromHex(id.hex()), id);
}

TEST(RequestId, RefusesTextThatIsNotThirtyTwoHexDigits) {
  EXPECT_FALSE(RequestId::fromHex(""));
  EXPECT_FALSE(RequestId::fromHex(std::string(31, 'a')));
  EXPECT_FALSE(RequestId::fromHex(std::string(33, 'a')));
  EXPECT_FALSE(RequestId::fromHex(std::string(31, 'a') + "g"));
}

TEST(RequestId, TwoRandomIdsDiffer) { EXPECT_NE(RequestId::random(), RequestId::random()); }

}  // namespace
}  // namespace handover
