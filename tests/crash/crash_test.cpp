// SPDX-License-Identifier: Apache-2.0
// Daemons and clients under faults drawn by seed: every answer keeps the rules all the same. A seed
// that fails is shrunk: the least of its faults that fails is printed.
// HANDOVER_CRASH_SEED: the first seed (default: 1); HANDOVER_CRASH_S: for how long seeds are run
// (default: three seeds of 5 s).
#include "world.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

namespace handover::test {
namespace {

using Clock = std::chrono::steady_clock;

int fromEnvironment(const char* name, int otherwise) {
  const char* given = std::getenv(name);
  return given == nullptr ? otherwise : std::atoi(given);
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

void tell(std::uint64_t seed, const std::vector<Fault>& faults, const RunReport& report) {
  std::cout << "seed " << seed << ": " << faults.size() << " faults, " << report.asked
            << " requests, " << report.done << " plans, " << report.killed << " clients killed, "
            << report.answers << " answers heard" << std::endl;
}

void runSeed(std::uint64_t seed, const WorldSettings& settings) {
  const std::vector<Fault> faults = drawFaults(seed, settings.length);
  const RunReport report = runWorld(settings, faults);
  tell(seed, faults, report);
  EXPECT_GT(report.done, 0) << "seed " << seed;
  if (report.faults.empty()) return;
  ADD_FAILURE() << "seed " << seed << ":\n" << joined(report.faults);
  const auto least = shrunk(faults, [&](const std::vector<Fault>& fewer) {
    return !runWorld(settings, fewer).faults.empty();
  });
  std::cout << "the least that fails:\n" << describe(least);
}

TEST(Crash, AnswersKeepTheRulesUnderFaults) {
  const auto first = static_cast<std::uint64_t>(fromEnvironment("HANDOVER_CRASH_SEED", 1));
  const int length_s = fromEnvironment("HANDOVER_CRASH_S", 0);
  WorldSettings settings;
  settings.length = 5s;
  const auto until = Clock::now() + std::chrono::seconds(length_s);
  for (std::uint64_t seed = first; length_s > 0 ? Clock::now() < until : seed < first + 3; ++seed) {
    // Every other run has two daemons, of a cell each.
    settings.daemons = seed % 2 == 1 ? std::vector<std::string>{"butler"}
                                     : std::vector<std::string>{"butler", "pick_place"};
    runSeed(seed, settings);
  }
}

}  // namespace
}  // namespace handover::test
