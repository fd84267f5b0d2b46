// SPDX-License-Identifier: Apache-2.0
#include "runtime/client_accounts.hpp"

#include <handover/common/log.hpp>

namespace handover {
namespace {

constexpr std::chrono::hours kHour{1};
constexpr double kMegabyte = 1e6;

}  // namespace

void ClientAccounts::charge(const std::string& client, double cpu_s, std::uint64_t cache_bytes,
                            Clock::time_point now) {
  std::erase_if(uses_, [&](const auto& entry) { return now - entry.second.since >= kHour; });
  Use& use = uses_.try_emplace(client, Use{now}).first->second;
  use.cpu_s += cpu_s;
  use.cache_bytes += cache_bytes;
}

std::string ClientAccounts::refusal(const std::string& client, Clock::time_point now) const {
  const auto found = uses_.find(client);
  if (found == uses_.end() || now - found->second.since >= kHour) return "";
  const Use& use = found->second;
  if (limits_.cpu_s > 0 && use.cpu_s >= limits_.cpu_s) {
    return fmt::format("the client used {:.1f} s of planning within an hour; its limit is {:.1f} s",
                       use.cpu_s, limits_.cpu_s);
  }
  if (limits_.cache_bytes > 0 && use.cache_bytes >= limits_.cache_bytes) {
    return fmt::format(
        "the client had {:.0f} MB of maps, grasp sets and parts made within an hour; its limit is "
        "{:.0f} MB",
        static_cast<double>(use.cache_bytes) / kMegabyte,
        static_cast<double>(limits_.cache_bytes) / kMegabyte);
  }
  return "";
}

}  // namespace handover
