// SPDX-License-Identifier: Apache-2.0
// Our verdicts and distances against FCL's, near contact, where checkers disagree if they do.
#include "core/collision/narrow_phase.hpp"
#include "fcl_shapes.hpp"
#include "random_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace handover::test {
namespace {

struct ShapePair {
  Shape a, b;
  Pose X_WA, X_WB;
};

// Two random shapes moved along the line of their nearest points until they are about `gap` apart.
ShapePair nearContact(RandomShapes& random, double gap) {
  ShapePair pair{random.any(), random.any(), random.pose(0.2), random.pose(0.2)};
  const NarrowShape a(pair.a), b(pair.b);
  const ShapeDistance found = shapeDistance(a, pair.X_WA, b, pair.X_WB);
  pair.X_WB.translation() += (found.distance - gap) * found.n_W;
  return pair;
}

class CollisionOracle : public testing::TestWithParam<std::uint64_t> {};

TEST_P(CollisionOracle, MissesNoOverlapAndReportsNothingBeyondThreeMillimetres) {
  RandomShapes random(GetParam());
  int overlaps = 0, apart = 0;
  for (int i = 0; i < 20000; ++i) {
    const ShapePair pair = nearContact(random, random.uniform(-0.005, 0.008));
    const NarrowShape a(pair.a), b(pair.b);
    const FclShape fcl_a(pair.a), fcl_b(pair.b);
    const bool touches = touching(a, pair.X_WA, b, pair.X_WB);
    EXPECT_EQ(touches, touching(b, pair.X_WB, a, pair.X_WA)) << "pair " << i;
    if (touches) {
      const FclDistance fcl = fclDistance(fcl_a, pair.X_WA, fcl_b, pair.X_WB);
      EXPECT_LE(fcl.low, 0.003) << "pair " << i;
      ++overlaps;
    } else {
      EXPECT_FALSE(fclOverlap(fcl_a, pair.X_WA, fcl_b, pair.X_WB)) << "pair " << i;
      ++apart;
    }
  }
  EXPECT_GT(overlaps, 5000);
  EXPECT_GT(apart, 5000);
}

TEST_P(CollisionOracle, DistancesAgree) {
  RandomShapes random(GetParam() + 100);
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    const ShapePair pair = nearContact(random, std::pow(10.0, random.uniform(-4, -0.5)));
    const NarrowShape a(pair.a), b(pair.b);
    const ShapeDistance ours = shapeDistance(a, pair.X_WA, b, pair.X_WB);
    if (ours.distance <= 0) continue;
    const FclDistance fcl = fclDistance(FclShape(pair.a), pair.X_WA, FclShape(pair.b), pair.X_WB);
    const double error =
        std::min(std::abs(ours.distance - fcl.low), std::abs(ours.distance - fcl.high));
    EXPECT_LT(error, 5e-5) << "pair " << i << " ours " << ours.distance << " FCL " << fcl.low << " "
                           << fcl.high;
    ++compared;
  }
  EXPECT_GT(compared, 10000);
}

INSTANTIATE_TEST_SUITE_P(Seeds, CollisionOracle, testing::Values(1, 2, 3));

}  // namespace
}  // namespace handover::test
