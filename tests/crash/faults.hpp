// SPDX-License-Identifier: Apache-2.0
// What goes wrong during a run, drawn from a seed, and the least of it that still fails.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace handover::test {

enum class FaultKind {
  kKillDaemon,  ///< started again after `lasts`
  kStopDaemon,  ///< SIGSTOP, SIGCONT after `lasts`
  kKillClient,
  kStopClient,  ///< SIGSTOP, SIGCONT after `lasts`
  kSlowReader,  ///< a reader of all events that takes none, for `lasts`
  kFullDisk,    ///< the daemon is killed and started again where no file can be written
  kFlipBits,    ///< in a file of the daemon's cache; it is killed and started again
  kClockStep,   ///< of the daemon's wall clock, by `amount` seconds
};
inline constexpr int kFaultKinds = 8;

struct Fault {
  std::chrono::milliseconds at{0}, lasts{0};  ///< from the begin of the run
  FaultKind kind = FaultKind::kKillDaemon;
  int target = 0;           ///< which daemon or client, modulo how many there are
  std::int64_t amount = 0;  ///< seconds of a clock's step, else what picks file and bits
  bool operator==(const Fault&) const = default;
};

std::string describe(const std::vector<Fault>& faults);

/// In order of time, about two a second; none begins in the last third, so that all can end well.
std::vector<Fault> drawFaults(std::uint64_t seed, std::chrono::milliseconds length);

/// The least that still fails by leaving faults out: halves first, then less, at last one by one.
/// @pre they fail.
std::vector<Fault> shrunk(std::vector<Fault> faults,
                          const std::function<bool(const std::vector<Fault>&)>& fails);

}  // namespace handover::test
