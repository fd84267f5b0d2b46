// SPDX-License-Identifier: Apache-2.0
// Who has the object and what it stands on: the state from which allowed contacts and holds follow.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace handover {

/// Places in a chain of holders.
class HolderSet {
 public:
  static constexpr std::size_t kMost = 32;

  HolderSet() = default;

  HolderSet(std::initializer_list<std::size_t> holders) {
    for (const std::size_t holder : holders) insert(holder);
  }

  /// @pre holder < kMost.
  void insert(std::size_t holder) { bits_ |= std::uint32_t{1} << holder; }

  void erase(std::size_t holder) { bits_ &= ~(std::uint32_t{1} << holder); }

  bool contains(std::size_t holder) const { return (bits_ >> holder & 1U) != 0; }

  bool empty() const { return bits_ == 0; }

  int size() const { return std::popcount(bits_); }

  HolderSet operator|(HolderSet other) const { return HolderSet(bits_ | other.bits_); }

  bool operator==(const HolderSet&) const = default;

  /// Calls visit(holder) in rising order.
  template <typename Visit>
  void forEach(const Visit& visit) const {
    for (std::uint32_t bits = bits_; bits != 0; bits &= bits - 1) {
      visit(static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }

 private:
  explicit HolderSet(std::uint32_t bits) : bits_(bits) {}

  std::uint32_t bits_ = 0;
};

/// What bears the object besides hands.
enum class Support { kNone, kStart, kGoal };

struct ObjectState {
  HolderSet holders;
  Support support = Support::kNone;
  bool operator==(const ObjectState&) const = default;
};

}  // namespace handover
