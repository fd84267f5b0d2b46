// SPDX-License-Identifier: Apache-2.0
#include "core/motion/ikbirrt.hpp"
#include "core/motion/random.hpp"

#include <algorithm>
#include <array>
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

// Leaves out every vertex that a straight segment can skip, the longest leap first.
void skipVertices(const MotionProblem& problem, Waypoints& path, const Deadline& deadline) {
  Waypoints kept{path.front()};
  for (std::size_t i = 0; i + 1 < path.size();) {
    std::size_t next = i + 1;
    for (std::size_t j = std::min(path.size() - 1, i + kLookAhead); j > i + 1; --j) {
      if (deadline.over()) break;
      if (segmentValid(problem, path[i], path[j])) {
        next = j;
        break;
      }
    }
    kept.push_back(path[next]);
    i = next;
  }
  path = std::move(kept);
}

// Joins two places by a straight segment if that is shorter and valid, with the ends of the two
// segments that it cuts: their own check points lie elsewhere now.
bool cut(const MotionProblem& problem, Waypoints& path, const Place& a, const Place& b) {
  if (a.vertex >= b.vertex) return false;
  double old = (path[a.vertex + 1] - a.q).norm() + (b.q - path[b.vertex]).norm();
  for (std::size_t i = a.vertex + 1; i < b.vertex; ++i) old += (path[i + 1] - path[i]).norm();
  if ((b.q - a.q).norm() > old - kLeastGain) return false;
  if (!segmentValid(problem, a.q, b.q)) return false;
  const bool keep_a = a.fraction > 0, keep_b = b.fraction < 1;
  if (keep_a && !segmentValid(problem, path[a.vertex], a.q)) return false;
  if (keep_b && !segmentValid(problem, b.q, path[b.vertex + 1])) return false;
  Waypoints shorter(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(a.vertex) + 1);
  if (keep_a) shorter.push_back(a.q);
  if (keep_b) shorter.push_back(b.q);
  shorter.insert(shorter.end(), path.begin() + static_cast<std::ptrdiff_t>(b.vertex) + 1,
                 path.end());
  path = std::move(shorter);
  return true;
}

bool cutAnywhere(const MotionProblem& problem, Waypoints& path, SeededRandom& random) {
  const double length = lengthOf(path);
  const double s = random.uniform(0, length), t = random.uniform(0, length);
  return cut(problem, path, placeAt(path, std::min(s, t)), placeAt(path, std::max(s, t)));
}

// Cuts one corner, deep first: at both neighbours' full, half, then quarter length.
bool cutCorner(const MotionProblem& problem, Waypoints& path, SeededRandom& random) {
  const std::size_t k = 1 + random.index(static_cast<std::uint32_t>(path.size() - 2));
  for (const double depth : {1.0, 0.5, 0.25}) {
    const double reach =
        depth * std::min((path[k] - path[k - 1]).norm(), (path[k + 1] - path[k]).norm());
    const double before = (path[k] - path[k - 1]).norm(), after = (path[k + 1] - path[k]).norm();
    if (!(reach > 0)) return false;
    Place a{k - 1, 1 - reach / before, {}}, b{k, reach / after, {}};
    a.q = a.fraction > 0 ? ArmVector(path[k] + reach / before * (path[k - 1] - path[k]))
                         : path[k - 1];
    b.q = b.fraction < 1 ? ArmVector(path[k] + b.fraction * (path[k + 1] - path[k])) : path[k + 1];
    if (cut(problem, path, a, b)) return true;
  }
  return false;
}

}  // namespace

bool segmentValid(const MotionProblem& problem, const ArmVector& from, const ArmVector& to) {
  const ArmVector move = to - from;
  const double largest = move.size() == 0 ? 0 : move.cwiseAbs().maxCoeff();
  if (!(largest < 1e6 * problem.resolution)) return false;  // catches NaN, too
  if (!problem.valid(to) || !problem.valid(from)) return false;
  const int steps = static_cast<int>(std::ceil(largest / problem.resolution));
  // Bisection by levels: middle, quarters, eighths ... each inner point once.
  int stride = 1;
  while (stride < steps) stride *= 2;
  ArmVector q(from.size());
  for (; stride >= 2; stride /= 2) {
    for (int k = stride / 2; k < steps; k += stride) {
      q = from + (static_cast<double>(k) / steps) * move;
      if (!problem.valid(q)) return false;
    }
  }
  return true;
}

JointPath shortcut(const MotionProblem& problem, const JointPath& path, std::uint64_t seed,
                   std::uint32_t attempts, const Deadline& deadline) {
  if (path.waypoints.size() < 3 || deadline.over()) return path;
  Waypoints points = path.waypoints;
  if (segmentValid(problem, points.front(), points.back()))
    return {{points.front(), points.back()}};
  skipVertices(problem, points, deadline);
  SeededRandom random(seed);
  for (std::uint32_t i = 0; i < attempts && points.size() > 2 && !deadline.over(); ++i) {
    if (i % 2 == 0) {
      cutAnywhere(problem, points, random);
    } else {
      cutCorner(problem, points, random);
    }
  }
  skipVertices(problem, points, deadline);
  return {std::move(points)};
}

}  // namespace handover
