// SPDX-License-Identifier: Apache-2.0
#include "faults.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <array>
#include <sstream>

namespace handover::test {
namespace {

const char* nameOf(FaultKind kind) {
  static constexpr std::array<const char*, kFaultKinds> kNames{
      "kill daemon", "stop daemon", "kill client", "stop client",
      "slow reader", "full disk",   "flip bits",   "clock step"};
  return kNames[static_cast<std::size_t>(kind)];
}

constexpr std::chrono::milliseconds kMeanGap{500};

}  // namespace

std::string describe(const std::vector<Fault>& faults) {
  std::ostringstream text;
  for (const Fault& fault : faults) {
    text << "  at " << fault.at.count() << " ms: " << nameOf(fault.kind) << ' ' << fault.target
         << " for " << fault.lasts.count() << " ms, amount " << fault.amount << '\n';
  }
  return text.str();
}

std::vector<Fault> drawFaults(std::uint64_t seed, std::chrono::milliseconds length) {
  SeededRandom random(seed);
  std::vector<Fault> faults;
  const auto last = length * 2 / 3;
  for (std::chrono::milliseconds at{0};;) {
    at += std::chrono::milliseconds(1 +
                                    random.index(static_cast<std::uint32_t>(2 * kMeanGap.count())));
    if (at >= last) return faults;
    Fault fault;
    fault.at = at;
    fault.kind = static_cast<FaultKind>(random.index(kFaultKinds));
    fault.lasts = std::chrono::milliseconds(50 + random.index(1500));
    fault.target = static_cast<int>(random.index(1000));
    fault.amount = static_cast<std::int64_t>(random.index(200'000)) - 100'000;
    faults.push_back(fault);
  }
}

std::vector<Fault> shrunk(std::vector<Fault> faults,
                          const std::function<bool(const std::vector<Fault>&)>& fails) {
  for (std::size_t size = (faults.size() + 1) / 2; size > 0;) {
    bool less = false;
    for (std::size_t from = 0; from < faults.size();) {
      const auto begin = faults.begin() + static_cast<std::ptrdiff_t>(from);
      const auto end = begin + static_cast<std::ptrdiff_t>(std::min(size, faults.size() - from));
      std::vector<Fault> fewer(faults.begin(), begin);
      fewer.insert(fewer.end(), end, faults.end());
      if (fails(fewer)) {
        faults = std::move(fewer);
        less = true;
      } else {
        from += size;
      }
    }
    if (!less) size /= 2;
    size = std::min(size, faults.size());
  }
  return faults;
}

}  // namespace handover::test
