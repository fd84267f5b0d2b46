// SPDX-License-Identifier: Apache-2.0
// Looking along time at a value whose rate is bounded, as seldom as the bound allows: nothing that
// exceeds a limit by more than the fineness slips between two looks.
#pragma once

#include "verify/unreadable.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace handover::verify {

/// Looks that one question may take: a hostile file must not take hours.
constexpr std::size_t kMostLooks = 3'000'000;

inline void countLook(std::size_t& looks) {
  if (++looks > kMostLooks) throw Unreadable("/plan/stages", "too much motion to be checked");
}

/// The first time at which value(T) > limit; a value that exceeds it by less than `fineness` in
/// between may be passed over. @param cuts from the first to the last time; rate(a, b) bounds the
/// value's change per second between two cuts that follow one another.
template <typename Value, typename Rate>
std::optional<double> firstAbove(const std::vector<double>& cuts, Value value, Rate rate,
                                 double limit, double fineness) {
  std::size_t looks = 0;
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const double fastest = rate(cuts[k], cuts[k + 1]);
    for (double T = cuts[k]; T < cuts[k + 1];) {
      countLook(looks);
      const double now = value(T);
      if (now > limit) return T;
      if (fastest <= 0) break;
      T += std::max(limit - now, fineness) / fastest;
    }
  }
  if (!cuts.empty() && value(cuts.back()) > limit) return cuts.back();
  return std::nullopt;
}

/// The greatest value(T), at most `fineness` less than the true one.
template <typename Value, typename Rate>
double greatest(const std::vector<double>& cuts, Value value, Rate rate, double fineness) {
  std::size_t looks = 0;
  double most = value(cuts.front());
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const double fastest = rate(cuts[k], cuts[k + 1]);
    for (double T = cuts[k]; T < cuts[k + 1];) {
      countLook(looks);
      const double now = value(T);
      most = std::max(most, now);
      if (fastest <= 0) break;
      T += (most - now + fineness) / fastest;
    }
  }
  return std::max(most, value(cuts.back()));
}

}  // namespace handover::verify
