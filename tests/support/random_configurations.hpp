// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/kinematics/arm_kinematics.hpp"

#include <cstdint>
#include <random>

namespace handover::test {

/// Configurations of an arm, uniform within its limits: the same ones on every machine.
class RandomConfigurations {
 public:
  RandomConfigurations(const ArmKinematics& arm, std::uint64_t seed)
      : arm_(arm), generator_(seed) {}

  double fraction() { return static_cast<double>(generator_() >> 11) * 0x1p-53; }

  ArmVector next() {
    ArmVector q(arm_.dofs());
    for (int i = 0; i < q.size(); ++i) {
      q[i] = arm_.lower()[i] + fraction() * (arm_.upper()[i] - arm_.lower()[i]);
    }
    return q;
  }

 private:
  const ArmKinematics& arm_;
  std::mt19937_64 generator_;
};

}  // namespace handover::test
