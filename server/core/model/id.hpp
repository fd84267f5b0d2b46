// SPDX-License-Identifier: Apache-2.0
// Indices that know what they are an index of, like Drake's TypeSafeIndex: a robot's number is no
// link's number.
#pragma once

#include <compare>
#include <concepts>
#include <cstddef>

namespace handover {

/// Index of an element of a fixed list, from 0; by default of none. Ids of different tags neither
/// convert into nor compare with each other, nor with numbers. An id is made from a number
/// explicitly, and is an index of the standard's containers without a cast (Eigen's want value());
/// nothing is computed with it but the next id.
template <class Tag>
class Id {
 public:
  constexpr Id() = default;

  /// @pre value fits an int; a negative one is none's.
  template <std::integral I>
  constexpr explicit Id(I value) : value_(static_cast<int>(value)) {}

  constexpr bool valid() const { return value_ >= 0; }

  /// -1: none.
  constexpr int value() const { return value_; }

  /// As an index, and of two types: so there is no way to arithmetic, comparison or a bool, of
  /// which each would have to choose between them. @pre valid().
  template <typename Index>
  requires std::same_as<Index, std::size_t> || std::same_as<Index, std::ptrdiff_t>

  constexpr operator Index() const {  // NOLINT(google-explicit-constructor)
    return static_cast<Index>(value_);
  }

  constexpr Id& operator++() {
    ++value_;
    return *this;
  }

  constexpr auto operator<=>(const Id&) const = default;

 private:
  int value_ = -1;
};

/// The first ids of a kind, for loops: from 0, `count` many.
template <class SomeId>
class IdRange {
 public:
  template <std::integral I>
  constexpr explicit IdRange(I count) : end_(count) {}

  class Iterator {
   public:
    constexpr explicit Iterator(SomeId id) : id_(id) {}

    constexpr SomeId operator*() const { return id_; }

    constexpr Iterator& operator++() {
      ++id_;
      return *this;
    }

    constexpr bool operator==(const Iterator&) const = default;

   private:
    SomeId id_;
  };

  constexpr Iterator begin() const { return Iterator(SomeId(0)); }

  constexpr Iterator end() const { return Iterator(end_); }

 private:
  SomeId end_;
};

}  // namespace handover
