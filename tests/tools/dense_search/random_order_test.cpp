// SPDX-License-Identifier: Apache-2.0
#include "dense_search/random_order.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace handover::dense {
namespace {

TEST(RandomOrder, HasEachNumberOnce) {
  for (const std::uint64_t size : {1u, 2u, 5u, 64u, 1000u, 4097u}) {
    const RandomOrder order(size, 7);
    std::vector<int> seen(size);
    for (std::uint64_t i = 0; i < size; ++i) ++seen.at(order(i));
    EXPECT_EQ(seen, std::vector<int>(size, 1)) << size;
  }
}

TEST(RandomOrder, DependsOnItsSeed) {
  const RandomOrder one(1'000'000, 1), same(1'000'000, 1), other(1'000'000, 2);
  int differ = 0;
  for (std::uint64_t i = 0; i < 100; ++i) {
    EXPECT_EQ(one(i), same(i));
    differ += one(i) != other(i) ? 1 : 0;
  }
  EXPECT_GT(differ, 90);
}

}  // namespace
}  // namespace handover::dense
