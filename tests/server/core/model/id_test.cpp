// SPDX-License-Identifier: Apache-2.0
#include "core/model/id.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <type_traits>
#include <vector>

namespace handover {
namespace {

using Cat = Id<struct CatTag>;
using Dog = Id<struct DogTag>;

template <typename A, typename B>
concept Comparable = requires(A a, B b) {
  a == b;
}

|| requires(A a, B b) { a < b; };

template <typename A, typename B>
concept Addable = requires(A a, B b) {
  a + b;
};

static_assert(!std::is_constructible_v<Cat, Dog>, "one kind is not made of another");
static_assert(!std::is_assignable_v<Cat&, Dog> && !std::is_assignable_v<Cat&, int>);
static_assert(Comparable<Cat, Cat> && !Comparable<Cat, Dog>, "kinds do not compare");
static_assert(!Comparable<Cat, int> && !Comparable<Cat, std::size_t>, "nor with numbers");
static_assert(!Addable<Cat, int> && !Addable<Cat, std::size_t> && !Addable<Cat, Cat>);
static_assert(std::is_constructible_v<Cat, int> && !std::is_convertible_v<int, Cat>);
static_assert(std::is_convertible_v<Cat, std::size_t>, "an id is an index");
static_assert(!std::is_constructible_v<int, Cat> && !std::is_constructible_v<bool, Cat>);
static_assert(sizeof(Cat) == sizeof(int) && std::is_trivially_copyable_v<Cat>);

TEST(Id, IsOfNothingByDefault) {
  EXPECT_FALSE(Cat().valid());
  EXPECT_EQ(Cat().value(), -1);
  EXPECT_EQ(Cat(), Cat(-1));
  EXPECT_TRUE(Cat(0).valid());
}

TEST(Id, IndexesAVectorWithoutACast) {
  const std::vector<std::string> names{"tom", "felix"};
  EXPECT_EQ(names[Cat(1)], "felix");
  EXPECT_EQ(names.at(Cat(0)), "tom");
  EXPECT_THROW(static_cast<void>(names.at(Cat())), std::out_of_range);
}

TEST(Id, IsOrderedAsItsNumbers) {
  std::vector<Cat> cats{Cat(2), Cat(0), Cat(), Cat(1)};
  std::sort(cats.begin(), cats.end());
  EXPECT_EQ(cats, (std::vector<Cat>{Cat(), Cat(0), Cat(1), Cat(2)}));
}

TEST(IdRange, GoesFromZeroUpToItsCount) {
  std::vector<int> seen;
  for (const Cat cat : IdRange<Cat>(std::size_t{3})) seen.push_back(cat.value());
  EXPECT_EQ(seen, (std::vector<int>{0, 1, 2}));
  for (const Cat cat : IdRange<Cat>(0)) ADD_FAILURE() << cat.value();
}

}  // namespace
}  // namespace handover
