// SPDX-License-Identifier: Apache-2.0
#include "core/motion/ikbirrt.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace handover {
namespace {

constexpr std::size_t kLookAhead = 24;  // vertices that one segment may replace in the first pass
constexpr double kLeastGain = 1e-6;     // [rad]

using Waypoints = std::vector<ArmVector>;

// A place on a path: on the segment after vertex `vertex`, at `fraction` of it.
struct Place {
  std::size_t vertex = 0;
  double fraction = 0;
  ArmVector q;
};

double lengthOf(const Waypoints& path) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) sum += (path[i + 1] - path[i]).norm();
  return sum;
}

Place placeAt(const Waypoints& path, double along) {
  for (std::size_t i = 0; i + 2 < path.size(); ++i) {
    const double length = (path[i + 1] - path[i]).norm();
    if (along < length)
      return {i, along / length, path[i] + along / length * (path[i + 1] - path[i])};
    along -= length;
  }
  const std::size_t last = path.size() - 2;
  const double length = (path[last + 1] - path[last]).norm();
  const double fraction = length > 0 ? std::min(1.0, along / length) : 0;
  return {last, fraction, path[last] + fraction * (path[last + 1] - path[last])};
}

// Leaves out every vertex that a straight segment can skip, the longest leap first. With `recheck`,
// segments that stay are walked, too; false if one of them is not valid.
bool skipVertices(const MotionProblem& problem, Waypoints& path, bool recheck,
                  const Deadline& deadline) {
  Waypoints kept{path.front()};
  for (std::size_t i = 0; i + 1 < path.size();) {
    std::size_t next = std::min(path.size() - 1, i + kLookAhead);
    const auto skips = [&] {
      return segmentValid(problem, path[i], path[next]) &&
             (kept.size() < 2 || cornerValid(problem, kept[kept.size() - 2], path[i], path[next]));
    };
    while (next > i + 1 && (deadline.over() || !skips())) --next;
    if (recheck && next == i + 1 && !segmentValid(problem, path[i], path[next])) return false;
    kept.push_back(path[next]);
    i = next;
  }
  path = std::move(kept);
  return true;
}

// The corners that a segment from `a` to `b` makes with what is left of the path.
bool cornersValid(const MotionProblem& problem, const Waypoints& path, const Place& a,
                  const Place& b) {
  const bool keep_a = a.fraction > 0, keep_b = b.fraction < 1;
  if (keep_a || a.vertex > 0) {
    const ArmVector& before = path[keep_a ? a.vertex : a.vertex - 1];
    if (!cornerValid(problem, before, a.q, b.q)) return false;
  }
  const std::size_t next = keep_b ? b.vertex + 1 : b.vertex + 2;
  return next >= path.size() || cornerValid(problem, a.q, b.q, path[next]);
}

// Joins two places by a straight segment if that is shorter and valid. What is left of the two
// segments that it cuts has been checked, but at points that a fresh walk would not take: `strict`
// walks it anew.
bool cut(const MotionProblem& problem, Waypoints& path, const Place& a, const Place& b,
         bool strict) {
  if (a.vertex >= b.vertex) return false;
  double old = (path[a.vertex + 1] - a.q).norm() + (b.q - path[b.vertex]).norm();
  for (std::size_t i = a.vertex + 1; i < b.vertex; ++i) old += (path[i + 1] - path[i]).norm();
  if ((b.q - a.q).norm() > old - kLeastGain) return false;
  if (!segmentValid(problem, a.q, b.q)) return false;
  const bool keep_a = a.fraction > 0, keep_b = b.fraction < 1;
  if ((keep_a && !problem.valid(a.q)) || (keep_b && !problem.valid(b.q))) return false;
  if (!cornersValid(problem, path, a, b)) return false;
  if (strict && keep_a && !segmentValid(problem, path[a.vertex], a.q)) return false;
  if (strict && keep_b && !segmentValid(problem, b.q, path[b.vertex + 1])) return false;
  Waypoints shorter(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(a.vertex) + 1);
  if (keep_a) shorter.push_back(a.q);
  if (keep_b) shorter.push_back(b.q);
  shorter.insert(shorter.end(), path.begin() + static_cast<std::ptrdiff_t>(b.vertex) + 1,
                 path.end());
  path = std::move(shorter);
  return true;
}

bool cutAnywhere(const MotionProblem& problem, Waypoints& path, SeededRandom& random, bool strict) {
  const double length = lengthOf(path);
  const double s = random.uniform(0, length), t = random.uniform(0, length);
  return cut(problem, path, placeAt(path, std::min(s, t)), placeAt(path, std::max(s, t)), strict);
}

// What an isosceles cut of the corner would save [rad].
double cornerGain(const Waypoints& path, std::size_t k) {
  const ArmVector before = path[k - 1] - path[k], after = path[k + 1] - path[k];
  const double b = before.norm(), a = after.norm(), reach = std::min(a, b);
  if (!(reach > 0)) return 0;
  return 2 * reach - (reach / a * after - reach / b * before).norm();
}

// Cuts one corner, the sharp and long ones more often, deep first: at the shorter neighbour's full,
// half, then quarter length.
bool cutCorner(const MotionProblem& problem, Waypoints& path, SeededRandom& random, bool strict) {
  double gains = 0;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) gains += cornerGain(path, i);
  double pick = random.uniform(0, gains);
  std::size_t k = 1;
  for (; k + 2 < path.size(); ++k) {
    pick -= cornerGain(path, k);
    if (pick < 0) break;
  }
  const ArmVector corner = path[k];
  const double before = (path[k - 1] - corner).norm(), after = (path[k + 1] - corner).norm();
  if (!(before > 0) || !(after > 0)) return false;
  for (const double depth : {1.0, 0.5, 0.25}) {
    const double reach = depth * std::min(before, after);
    Place a{k - 1, 1 - reach / before, path[k - 1]}, b{k, reach / after, path[k + 1]};
    if (a.fraction > 0) a.q = corner + reach / before * (path[k - 1] - corner);
    if (b.fraction < 1) b.q = corner + reach / after * (path[k + 1] - corner);
    if (cut(problem, path, a, b, strict)) return true;
  }
  return false;
}

void cutRandomly(const MotionProblem& problem, Waypoints& path, std::uint64_t seed,
                 std::uint32_t attempts, bool strict, const Deadline& deadline) {
  SeededRandom random(seed);
  for (std::uint32_t i = 0; i < attempts && path.size() > 2 && !deadline.over(); ++i) {
    if (i % 2 == 0) {
      cutAnywhere(problem, path, random, strict);
    } else {
      cutCorner(problem, path, random, strict);
    }
  }
}

}  // namespace

JointPath shortcut(const MotionProblem& problem, const JointPath& path, std::uint64_t seed,
                   std::uint32_t attempts, const Deadline& deadline) {
  if (path.waypoints.size() < 3 || deadline.over()) return path;
  Waypoints points = path.waypoints;
  if (segmentValid(problem, points.front(), points.back()))
    return {{points.front(), points.back()}};
  skipVertices(problem, points, false, deadline);
  Waypoints cheap = points;
  cutRandomly(problem, cheap, seed, attempts, false, deadline);
  // Part of a segment that is valid as a whole needs no second look.
  const bool recheck = !problem.valid_between;
  if (skipVertices(problem, cheap, recheck, deadline)) return {std::move(cheap)};
  cutRandomly(problem, points, seed, attempts, true, deadline);
  return {std::move(points)};
}

}  // namespace handover
