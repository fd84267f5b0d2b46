// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

namespace handover {

/// What one client may use within an hour; 0: no limit.
struct ClientLimits {
  double cpu_s = 0;               ///< of workers and of making what its requests lack
  std::uint64_t cache_bytes = 0;  ///< of maps, grasp sets and parts that its requests had made
};

/// What each client used of late. Not safe from several threads.
class ClientAccounts {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ClientAccounts(const ClientLimits& limits) : limits_(limits) {}

  void charge(const std::string& client, double cpu_s, std::uint64_t cache_bytes,
              Clock::time_point now);
  /// Why it may use no more for now; empty: it may.
  std::string refusal(const std::string& client, Clock::time_point now) const;

 private:
  struct Use {
    Clock::time_point since;  ///< the hour starts anew with the first use after its end
    double cpu_s = 0;
    std::uint64_t cache_bytes = 0;
  };

  const ClientLimits limits_;
  std::map<std::string, Use> uses_;
};

}  // namespace handover
