// SPDX-License-Identifier: Apache-2.0
// Right plans with one fault planted, and what the program says of them.
#pragma once

#include "gantry_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace handover::verify::test {

class SpoiledPlan : public testing::Test {
 protected:
  using Fault = std::function<void(Json&)>;

  ProgramResult spoiled(const PlanOptions& options, const Fault& fault) const {
    Json file = cell_.plan(options);
    fault(file);
    return verify(cell_, file);
  }

  /// The fault is found as this kind, and nothing else is.
  void expectOnly(const std::string& kind, const PlanOptions& options, const Fault& fault) const {
    const ProgramResult result = spoiled(options, fault);
    EXPECT_EQ(result.exit_code, 1) << result.output;
    EXPECT_THAT(result.kinds, testing::Not(testing::IsEmpty())) << result.output;
    EXPECT_THAT(result.kinds, testing::Each(kind)) << result.output;
  }

  void expectOnly(const std::string& kind, const Fault& fault) const {
    expectOnly(kind, {}, fault);
  }

  void expectValid(const PlanOptions& options, const Fault& fault) const {
    const ProgramResult result = spoiled(options, fault);
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }

  void expectValid(const Fault& fault) const { expectValid({}, fault); }

  GantryCell cell_;
};

inline void addTo(Json& value, double by) { value = value.get<double>() + by; }

/// Adds `by` times profile(u), u from 0 to 1 over the stage, to a column of q, with the derivatives
/// that belong to it. The profile is a polynomial by its coefficients.
inline void addProfile(Json& stage, std::size_t column, double by,
                       const std::vector<double>& profile) {
  const double duration = stage["t"].back();
  for (std::size_t k = 0; k < stage["t"].size(); ++k) {
    const double u = stage["t"][k].get<double>() / duration;
    double q = 0, qd = 0, qdd = 0;
    for (std::size_t n = profile.size(); n-- > 0;) {
      qdd = qdd * u + 2 * qd;
      qd = qd * u + q;
      q = q * u + profile[n];
    }
    addTo(stage["q"][k][column], by * q);
    addTo(stage["qd"][k][column], by * qd / duration);
    addTo(stage["qdd"][k][column], by * qdd / duration / duration);
  }
}

/// From 0 to 1, from rest to rest.
inline const std::vector<double>& step() {
  static const std::vector<double> kStep = {0, 0, 0, 10, -15, 6};
  return kStep;
}

/// From 0 to 1 in the middle and back.
inline const std::vector<double>& bump() {
  static const std::vector<double> kBump = {0, 0, 0, 64, -192, 192, -64};
  return kBump;
}

/// Moves the end of a motion and the beginning of the one that follows it.
inline void moveKnot(Json& before, Json& after, std::size_t column, double by) {
  addProfile(before, column, by, step());
  addProfile(after, column, by, {1, 0, 0, -10, 15, -6});
}

}  // namespace handover::verify::test
