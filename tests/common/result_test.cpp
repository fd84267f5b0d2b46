// SPDX-License-Identifier: Apache-2.0
#include <handover/common/result.hpp>

#include <gtest/gtest.h>

#include <type_traits>

namespace handover {
namespace {

static_assert(!std::is_constructible_v<Result<void>, bool>, "a status is no flag");

TEST(ResultOfNothing, IsDoneByDefault) {
  const Result<void> done;
  EXPECT_TRUE(done);
  EXPECT_TRUE(done.has_value());
}

TEST(ResultOfNothing, HasTheReasonWhyNot) {
  const Result<void> failed = Error{ErrorCode::kIo, "disk full"};
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error(), (Error{ErrorCode::kIo, "disk full"}));
  EXPECT_EQ(Result<void>(ErrorCode::kNotFound, "x").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace handover
