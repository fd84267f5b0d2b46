// SPDX-License-Identifier: Apache-2.0
#include "rounds.hpp"

#include <algorithm>
#include <chrono>

namespace handover::bench {

std::vector<double> medianRounds(int rounds,
                                 const std::vector<std::function<void()>>& contestants) {
  using Clock = std::chrono::steady_clock;
  const std::size_t count = contestants.size();
  for (const auto& run : contestants) run();
  std::vector<std::vector<double>> times(count);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t turn = (k + static_cast<std::size_t>(round)) % count;
      const auto begin = Clock::now();
      contestants[turn]();
      times[turn].push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    }
  }
  std::vector<double> medians;
  for (const auto& of_one : times) medians.push_back(quantile(of_one, 0.5));
  return medians;
}

double quantile(std::vector<double> values, double part) {
  std::sort(values.begin(), values.end());
  const double place = part * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace handover::bench
