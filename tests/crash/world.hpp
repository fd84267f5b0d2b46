// SPDX-License-Identifier: Apache-2.0
// Daemons, clients and a recorder on a domain of their own, to which a run's faults happen.
#pragma once

#include "faults.hpp"
#include "process.hpp"
#include "temporary_folder.hpp"
#include "wire_checker.hpp"

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace handover::test {

struct WorldSettings {
  std::vector<std::string> daemons{"butler"};  ///< the cell of each
  int clients = 2;                             ///< that ask at the same time
  std::chrono::milliseconds length{6000};      ///< as long new requests are made
};

struct RunReport {
  std::vector<std::string> faults;  ///< what broke a rule
  int asked = 0, done = 0, killed = 0;
  int answers = 0;  ///< outcomes heard on the wire
};

/// Runs it: what the checkers found. A clean run has daemons that stop orderly, clients that end in
/// their own time, answers by the rules, and plans that the verifier accepts.
RunReport runWorld(const WorldSettings& settings, const std::vector<Fault>& faults);

/// Where Debian's faketime keeps its library; empty: it is not installed, clocks do not step.
std::string fakeTimeLibrary();

}  // namespace handover::test
