// SPDX-License-Identifier: Apache-2.0
#include "core/motion/timing.hpp"
#include "timing_cases.hpp"

namespace handover::test {
namespace {

using Polylines = std::vector<std::vector<VectorXd>>;

/// A way in some pieces, each of one or more lines.
Polylines randomPolylines(Random& random, const TimingLimits& limits) {
  Polylines polylines;
  VectorXd at = random.point(limits);
  const int pieces = 2 + random.upTo(2);
  for (int i = 0; i < pieces; ++i) {
    std::vector<VectorXd> polyline{at};
    const int lines = 1 + random.upTo(2);
    for (int k = 0; k < lines; ++k) {
      polyline.push_back(polyline.back() +
                         random.uniform(0.15, 0.4) * (random.point(limits) - polyline.back()));
    }
    at = polyline.back();
    polylines.push_back(polyline);
  }
  return polylines;
}

std::vector<VectorXd> concatenated(const Polylines& polylines) {
  std::vector<VectorXd> all{polylines.front().front()};
  for (const auto& it : polylines) all.insert(all.end(), it.begin() + 1, it.end());
  return all;
}

TEST(JoinedTiming, IsSoundAndDoesNotStopAtJunctions) {
  const TimingLimits limits = armLimits();
  Random random(31);
  double joined_time = 0, separate_time = 0;
  for (int run = 0; run < 80; ++run) {
    SCOPED_TRACE(run);
    const Polylines polylines = randomPolylines(random, limits);
    const auto joined = parameterizeJoined(polylines, limits, {});
    ASSERT_TRUE(joined) << joined.error().detail;
    expectSound(joined->path, concatenated(polylines), limits, {});
    ASSERT_EQ(joined->junctions.size(), polylines.size() - 1);
    double separate = 0;
    for (const auto& polyline : polylines) {
      const auto alone = parameterize(polyline, limits, {});
      ASSERT_TRUE(alone);
      separate += alone->duration();
    }
    EXPECT_LE(joined->path.duration(), separate);
    joined_time += joined->path.duration();
    separate_time += separate;
    const auto whole = parameterize(concatenated(polylines), limits, {});
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->duration(), joined->path.duration());
    for (const Junction& junction : joined->junctions) {
      EXPECT_GT(joined->path.qd[junction.nearest].norm(), 1e-3);
    }
  }
  RecordProperty("joined_over_separate", std::to_string(joined_time / separate_time));
  EXPECT_LT(joined_time, 0.95 * separate_time);
}

TEST(JoinedTiming, PiecesStayOnTheirPolylines) {
  const TimingLimits limits = armLimits();
  Random random(32);
  constexpr double kBends = 0.003;  // what smoothing may
  for (int run = 0; run < 80; ++run) {
    SCOPED_TRACE(run);
    const Polylines polylines = randomPolylines(random, limits);
    const auto joined = parameterizeJoined(polylines, limits, {});
    ASSERT_TRUE(joined);
    const TimedPath& path = joined->path;
    std::size_t begin = 0;
    for (std::size_t k = 0; k < polylines.size(); ++k) {
      const bool last = k + 1 == polylines.size();
      const std::size_t end = last ? path.t.size() - 1 : joined->junctions[k].first;
      if (!last) {
        const auto [first, nearest, after] = joined->junctions[k];
        EXPECT_LT(first, after);
        EXPECT_LE(first, nearest);
        EXPECT_LE(nearest, after);
        EXPECT_LT((path.q[nearest] - polylines[k].back()).norm(), 0.05 + 0.04);
      }
      // Between junctions on the polyline with its inner corners blended, near the ends on the
      // straight lines themselves.
      for (std::size_t i = begin; i <= end && begin < end; ++i) {
        EXPECT_LE(deviation(polylines[k], path.q[i]), 0.05 + kBends);
      }
      if (begin < end) {
        const std::vector<VectorXd> first_line{polylines[k][0], polylines[k][1]};
        const std::vector<VectorXd> last_line{polylines[k].end()[-2], polylines[k].back()};
        EXPECT_LE(deviation(first_line, path.q[begin]), kBends);
        EXPECT_LE(deviation(last_line, path.q[end]), kBends);
      }
      if (!last) begin = joined->junctions[k].last;
    }
  }
}

TEST(JoinedTiming, AStraightPieceIsStraightFromTheLastSampleOfItsJunction) {
  // A way to above an object, and down: as a reach and an approach.
  const TimingLimits limits = armLimits();
  Random random(33);
  for (int run = 0; run < 100; ++run) {
    const VectorXd start = random.point(limits), above = 0.7 * random.point(limits);
    const std::vector<VectorXd> line{above, above + 0.1 * random.point(limits)};
    const auto joined = parameterizeJoined({{start, above}, line}, limits, {});
    ASSERT_TRUE(joined);
    const std::size_t cut = joined->junctions[0].last;
    ASSERT_LT(cut, joined->path.t.size() - 1);
    const TimedPath approach = slice(joined->path, cut, joined->path.t.size() - 1);
    for (int k = 0; k <= 100; ++k) {
      EXPECT_LE(deviation(line, evaluate(approach, 0.01 * k * approach.duration())), 1.2e-4) << run;
    }
    const TimedPath reach = slice(joined->path, 0, joined->junctions[0].first);
    for (int k = 0; k <= 100; ++k) {
      EXPECT_LE(deviation({start, above}, evaluate(reach, 0.01 * k * reach.duration())), 1.2e-4);
    }
  }
}

TEST(JoinedTiming, StopsWithoutBlend) {
  const TimingLimits limits = armLimits();
  Random random(34);
  const Polylines polylines = randomPolylines(random, limits);
  TimingSettings settings;
  settings.blend = 0;
  const auto joined = parameterizeJoined(polylines, limits, settings);
  ASSERT_TRUE(joined);
  expectSound(joined->path, concatenated(polylines), limits, settings);
  for (std::size_t k = 0; k < joined->junctions.size(); ++k) {
    const Junction& junction = joined->junctions[k];
    EXPECT_EQ(junction.first, junction.last);
    EXPECT_EQ(junction.first, junction.nearest);
    EXPECT_EQ(joined->path.q[junction.first], polylines[k].back());
    EXPECT_EQ(joined->path.qd[junction.first].norm(), 0);
    EXPECT_EQ(joined->path.qdd[junction.first].norm(), 0);
  }
}

TEST(JoinedTiming, TakesPiecesThatGoNowhere) {
  const TimingLimits limits = uniformLimits(2, 2, 1, 1);
  const VectorXd a = Eigen::Vector2d(0, 0), b = Eigen::Vector2d(1, 0), c = Eigen::Vector2d(1, 1);
  const auto joined = parameterizeJoined({{a}, {a, b}, {b, b}, {b, c}, {c}}, limits, {});
  ASSERT_TRUE(joined);
  const std::size_t last = joined->path.t.size() - 1;
  ASSERT_EQ(joined->junctions.size(), 4u);
  EXPECT_EQ(joined->junctions[0].last, 0u);
  EXPECT_EQ(joined->junctions[1].first, joined->junctions[2].first);
  EXPECT_EQ(joined->junctions[1].last, joined->junctions[2].last);
  EXPECT_EQ(joined->junctions[3].first, last);
  const auto still = parameterizeJoined({{a}, {a, a}}, limits, {});
  ASSERT_TRUE(still);
  EXPECT_EQ(still->path.t.size(), 2u);
  EXPECT_EQ(still->junctions.size(), 1u);
}

TEST(JoinedTiming, RejectsPiecesThatDoNotMeet) {
  const TimingLimits limits = uniformLimits(2, 2, 1, 1);
  const VectorXd a = Eigen::Vector2d(0, 0), b = Eigen::Vector2d(1, 0), c = Eigen::Vector2d(1, 1);
  for (const Polylines& bad : {Polylines{}, Polylines{{}}, Polylines{{a, b}, {}},
                               Polylines{{a, b}, {c, a}}, Polylines{{a, b}, {b, 3 * c}}}) {
    const auto joined = parameterizeJoined(bad, limits, {});
    ASSERT_FALSE(joined);
    EXPECT_EQ(joined.error().code, ErrorCode::kInvalidInput);
  }
}

}  // namespace
}  // namespace handover::test
