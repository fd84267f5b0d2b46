// SPDX-License-Identifier: Apache-2.0
// A small generator whose numbers depend on the seed alone, on every machine and library.
#pragma once

#include <cstdint>

namespace handover {

/// SplitMix64 (Steele, Lea, Flood 2014).
class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    std::uint64_t z = (state_ += kStep);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// What the n-th call of bits() gives, n from 0, without the calls before.
  static std::uint64_t bitsAt(std::uint64_t seed, std::uint64_t n) {
    return SeededRandom(seed + n * kStep).bits();
  }

  /// A number scrambled.
  static std::uint64_t mix(std::uint64_t x) { return SeededRandom(x).bits(); }

  /// In [0, 1).
  double unit() { return toUnit(bits()); }

  static double toUnit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

  double uniform(double low, double high) { return low + (high - low) * unit(); }

  /// In [0, count). @pre count > 0.
  std::uint32_t index(std::uint32_t count) { return static_cast<std::uint32_t>(unit() * count); }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15u;

  std::uint64_t state_;
};

}  // namespace handover
