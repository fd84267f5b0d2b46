// SPDX-License-Identifier: Apache-2.0
// Fast DDS alone: 256 bytes there and back between two processes, RELIABLE, over the same transport
// as ours (UDP on loopback), by listeners.
#pragma once

#include <chrono>
#include <memory>

namespace handover::bench {

/// Sends every ping of the domain back; never returns. @throws std::runtime_error.
void answerPings(int domain);

/// The asking side.
class Ping {
 public:
  /// Waits until somebody answers in the domain. @throws std::runtime_error after `wait`.
  Ping(int domain, std::chrono::milliseconds wait);
  ~Ping();

  /// From the write to the answer's arrival. @throws std::runtime_error when none comes.
  std::chrono::duration<double> roundTrip();

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace handover::bench
