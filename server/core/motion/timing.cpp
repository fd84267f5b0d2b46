// SPDX-License-Identifier: Apache-2.0
#include "core/motion/timing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

namespace handover {
namespace {

using Eigen::VectorXd;

constexpr double kMinSegment = 2e-5;     // [rad] shorter ones make cells that rounding spoils
constexpr double kRestDuration = 1e-3;   // [s] of a motion that goes nowhere
constexpr double kPositionSlack = 1e-9;  // [rad]
constexpr int kCellsPerPath = 100;       // grid cells along the straight parts, about
constexpr double kCellsPerTurn = 10;     // grid cells of a blend, per unit of |change of direction|
constexpr int kRefinements = 3;          // doublings of the grid when the first one is too coarse
constexpr double kGoodStretch = 1.05;
constexpr double kHuge = 1e300;

// The path cut into cells of the parameter s. In cell i, q_ss is constant and q_s goes linearly
// from q_s[i] to q_s[i + 1], so with u = s'' constant the acceleration q_ss x + q_s u (x = s'^2) is
// linear in s and has its extremes at the cell's ends.
struct Grid {
  std::size_t dof = 0;
  std::vector<double> ds;         // per cell
  std::vector<double> curvature;  // q_ss, dof per cell
  std::vector<char> straight;     // per cell: q_ss = 0
  std::vector<double> q, q_s;     // dof per point
  std::vector<char> stop;         // per point: at rest there
  std::vector<char> inner;        // per point: inside a straight line

  std::size_t cells() const { return ds.size(); }

  std::size_t points() const { return stop.size(); }
};

// Two-sided bound on u, linear in x: |u + slope x| <= reach.
struct Row {
  double reach, slope;
};

struct Corner {
  double half = 0;  // [rad] of the parabola before and after the corner
  double turn = 0;  // |change of the unit direction|
};

// Appends cells from the last point of the grid: `count` equal ones over `length` with the
// curvature c.
void appendCells(Grid& grid, double length, const double* c, bool straight, int count) {
  const std::size_t dof = grid.dof;
  const std::size_t base = grid.points() - 1;
  for (int k = 1; k <= count; ++k) {
    const double s = length * k / count;
    grid.ds.push_back(length / count);
    grid.straight.push_back(straight);
    grid.stop.push_back(0);
    grid.inner.push_back(straight && k < count);
    for (std::size_t j = 0; j < dof; ++j) {
      const double cj = straight ? 0.0 : c[j];
      const double dj = grid.q_s[base * dof + j];
      grid.curvature.push_back(cj);
      grid.q.push_back(grid.q[base * dof + j] + (dj + 0.5 * cj * s) * s);
      grid.q_s.push_back(dj + cj * s);
    }
  }
}

// Moves the grid's last point straight on by a sliver that is too short for a cell of its own.
void extendLastCell(Grid& grid, double length) {
  const std::size_t dof = grid.dof, n = grid.cells();
  grid.ds.back() += length;
  for (std::size_t j = 0; j < dof; ++j) {
    const double d1 = grid.q_s[n * dof + j];
    grid.q[n * dof + j] += length * d1;
    grid.curvature[(n - 1) * dof + j] = (d1 - grid.q_s[(n - 1) * dof + j]) / grid.ds.back();
  }
}

Grid makeGrid(const std::vector<VectorXd>& points, double blend, int refine) {
  const std::size_t segments = points.size() - 1;
  Grid grid;
  grid.dof = static_cast<std::size_t>(points.front().size());
  const auto dof = static_cast<Eigen::Index>(grid.dof);

  Eigen::MatrixXd direction(dof, segments);
  VectorXd length(segments);
  double total = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    direction.col(k) = points[i + 1] - points[i];
    length[k] = direction.col(k).norm();
    direction.col(k) /= length[k];
    total += length[k];
  }
  std::vector<Corner> corners(segments + 1);
  for (std::size_t i = 1; i < segments; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    corners[i].turn = (direction.col(k) - direction.col(k - 1)).norm();
    corners[i].half = 0.5 * std::min(length[k - 1], length[k]);
    // The parabola passes the corner at a distance of half * turn / 4.
    if (corners[i].half * corners[i].turn > 4 * blend) {
      corners[i].half = 4 * blend / corners[i].turn;
    }
    if (corners[i].half < 0.25 * kMinSegment) corners[i].half = 0;
  }

  const std::size_t guess = static_cast<std::size_t>(refine) * (kCellsPerPath + 4 + 8 * segments);
  grid.ds.reserve(guess);
  grid.straight.reserve(guess);
  grid.stop.reserve(guess);
  grid.inner.reserve(guess);
  grid.curvature.reserve(guess * grid.dof);
  grid.q.reserve(guess * grid.dof);
  grid.q_s.reserve(guess * grid.dof);

  grid.q.assign(points[0].data(), points[0].data() + dof);
  grid.q_s.assign(direction.data(), direction.data() + dof);
  grid.stop.push_back(1);
  grid.inner.push_back(0);
  VectorXd curvature(dof);
  for (std::size_t i = 0; i < segments; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double rest = length[k] - corners[i].half - corners[i + 1].half;
    const bool stops_before = corners[i].half == 0, stops_after = corners[i + 1].half == 0;
    if (i == 0 || rest >= std::max(0.005 * corners[i].half, 0.05 * kMinSegment)) {
      int count = static_cast<int>(std::ceil(kCellsPerPath * rest / total));
      if (stops_before || stops_after) count = std::max(count, 2);
      appendCells(grid, rest, nullptr, true, count * refine);
    } else if (rest > 0) {
      extendLastCell(grid, rest);
    }
    if (i + 1 == segments) break;
    const Corner& corner = corners[i + 1];
    if (corner.half > 0) {
      const double span = 2 * corner.half;
      curvature = (direction.col(k + 1) - direction.col(k)) / span;
      const double by_turn = kCellsPerTurn * corner.turn;
      const double by_length = 0.25 * kCellsPerPath * span / total;
      const int count = std::max(1, static_cast<int>(std::ceil(std::max(by_turn, by_length))));
      appendCells(grid, span, curvature.data(), false, count * refine);
    } else {
      grid.stop.back() = 1;
    }
    // The directions of the segments themselves, so that rounding does not pile up along the path.
    const std::size_t last = grid.points() - 1;
    for (Eigen::Index j = 0; j < dof; ++j) {
      const auto at = last * grid.dof + static_cast<std::size_t>(j);
      grid.q_s[at] = direction(j, k + 1);
      grid.q[at] = points[i + 1][j] + corner.half * direction(j, k + 1);
    }
  }
  grid.stop.back() = 1;
  for (Eigen::Index j = 0; j < dof; ++j) {
    grid.q[(grid.points() - 1) * grid.dof + static_cast<std::size_t>(j)] = points.back()[j];
  }
  return grid;
}

// The fastest x = s'^2 on the grid's points.
class SpeedProfile {
 public:
  SpeedProfile(const Grid& grid, const TimingLimits& limits) : grid_(grid) {
    makeRows(limits);
    cap(limits);
    backward();
    forward();
  }

  const std::vector<double>& x() const { return x_; }

 private:
  // Bounds on u in cell i at x; `high` and `low` are lines c0 + c1 x.
  struct Range {
    double high0, high1, low0, low1;

    double high(double x) const { return high0 + high1 * x; }

    double low(double x) const { return low0 + low1 * x; }
  };

  void makeRows(const TimingLimits& limits) {
    const std::size_t dof = grid_.dof, n = grid_.cells();
    rows_.resize(n * 2 * dof);
    row_cap_.assign(n, kHuge);
    straight_reach_.assign(n, kHuge);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < dof; ++j) {
        const double a = limits.acceleration[static_cast<Eigen::Index>(j)];
        const double b = grid_.curvature[i * dof + j];
        const double c0 = grid_.q_s[i * dof + j];
        if (grid_.straight[i]) {
          straight_reach_[i] = std::min(straight_reach_[i], a / std::max(std::abs(c0), 1e-12));
          continue;
        }
        // At the cell's end x is x + 2 ds u and q_s is the next point's.
        const double c1 = grid_.q_s[(i + 1) * dof + j] + 2 * grid_.ds[i] * b;
        rows_[(2 * i) * dof + j] = makeRow(i, a, b, c0);
        rows_[(2 * i + 1) * dof + j] = makeRow(i, a, b, c1);
      }
    }
  }

  Row makeRow(std::size_t cell, double a, double b, double c) {
    if (std::abs(c) > 1e-9) return {a / std::abs(c), b / c};
    if (b != 0) row_cap_[cell] = std::min(row_cap_[cell], a / std::abs(b));
    return {kHuge, 0};
  }

  // Speed limits: |q_s| is largest at the ends of a cell, and so is x.
  void cap(const TimingLimits& limits) {
    const std::size_t dof = grid_.dof, n = grid_.cells();
    cap_.assign(n + 1, kHuge);
    for (std::size_t i = 0; i < n; ++i) {
      double x = row_cap_[i];
      for (std::size_t j = 0; j < dof; ++j) {
        const double q_s =
            std::max(std::abs(grid_.q_s[i * dof + j]), std::abs(grid_.q_s[(i + 1) * dof + j]));
        const double v = limits.velocity[static_cast<Eigen::Index>(j)];
        if (q_s * 1e150 > v) x = std::min(x, (v / q_s) * (v / q_s));
      }
      cap_[i] = std::min(cap_[i], x);
      cap_[i + 1] = std::min(cap_[i + 1], x);
    }
    for (std::size_t i = 0; i <= n; ++i) {
      if (grid_.stop[i]) cap_[i] = 0;
    }
  }

  // The tightest bounds at x; `next` is the greatest x allowed at the cell's end.
  Range range(std::size_t i, double x, double next) const {
    const double per = 1 / (2 * grid_.ds[i]);
    Range r{next * per, -per, 0, -per};
    if (grid_.straight[i]) {
      if (straight_reach_[i] < r.high(x)) r.high0 = straight_reach_[i], r.high1 = 0;
      if (-straight_reach_[i] > r.low(x)) r.low0 = -straight_reach_[i], r.low1 = 0;
      return r;
    }
    double high = r.high(x), low = r.low(x);
    const Row* rows = &rows_[2 * i * grid_.dof];
    for (std::size_t k = 0; k < 2 * grid_.dof; ++k) {
      const double shift = rows[k].slope * x;
      if (rows[k].reach - shift < high) {
        high = rows[k].reach - shift;
        r.high0 = rows[k].reach, r.high1 = -rows[k].slope;
      }
      if (-rows[k].reach - shift > low) {
        low = -rows[k].reach - shift;
        r.low0 = -rows[k].reach, r.low1 = -rows[k].slope;
      }
    }
    return r;
  }

  // Greatest x of each point from which the end can be reached at rest. x = 0, u = 0 keeps every
  // bound, so the set is [0, reach]; its end is found by cutting with the two bounds that cross
  // until none do.
  void backward() {
    const std::size_t n = grid_.cells();
    reach_.assign(n + 1, 0);
    for (std::size_t i = n; i-- > 0;) {
      double x = cap_[i];
      for (int cut = 0; cut < 100 && x > 0; ++cut) {
        const Range r = range(i, x, reach_[i + 1]);
        const double gap = r.low(x) - r.high(x);
        if (gap <= 1e-12 * (std::abs(r.low(x)) + std::abs(r.high(x)))) break;
        x = std::clamp((r.high0 - r.low0) / (r.low1 - r.high1), 0.0, x);
      }
      reach_[i] = x;
    }
  }

  void forward() {
    const std::size_t n = grid_.cells();
    x_.assign(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i) {
      const double u = range(i, x_[i], reach_[i + 1]).high(x_[i]);
      x_[i + 1] = std::clamp(x_[i] + 2 * grid_.ds[i] * u, 0.0, reach_[i + 1]);
    }
  }

  const Grid& grid_;
  std::vector<Row> rows_;                         // per cell: dof at its start, dof at its end
  std::vector<double> row_cap_, straight_reach_;  // per cell
  std::vector<double> cap_, reach_, x_;           // per point
};

// Samples at the grid's points; inside a straight line only where u changes, for there the curve is
// a parabola in t that a Hermite cubic meets exactly.
bool sample(const Grid& grid, const std::vector<double>& x, const TimingLimits& limits,
            TimedPath& path) {
  const auto dof = static_cast<Eigen::Index>(grid.dof);
  const std::size_t n = grid.cells();
  path.t.reserve(n + 1);
  path.q.reserve(n + 1);
  path.qd.reserve(n + 1);
  double t = 0;
  for (std::size_t i = 0; i <= n; ++i) {
    if (i > 0) {
      const double speeds = std::sqrt(x[i - 1]) + std::sqrt(x[i]);
      if (!(speeds > 0)) return false;
      t += 2 * grid.ds[i - 1] / speeds;
    }
    if (grid.inner[i]) {
      const double u0 = (x[i] - x[i - 1]) / grid.ds[i - 1], u1 = (x[i + 1] - x[i]) / grid.ds[i];
      if (std::abs(u1 - u0) <= 1e-9 * (std::abs(u0) + std::abs(u1))) continue;
    }
    path.t.push_back(t);
    const Eigen::Map<const VectorXd> q(&grid.q[i * grid.dof], dof),
        q_s(&grid.q_s[i * grid.dof], dof);
    if (i == 0 || i == n) {
      path.q.emplace_back(q);
      path.qd.emplace_back(VectorXd::Zero(dof));
    } else {
      path.q.emplace_back(q.cwiseMax(limits.lower).cwiseMin(limits.upper));
      path.qd.emplace_back(std::sqrt(x[i]) * q_s);
    }
  }
  return true;
}

// One joint's Hermite cubic over one interval; the acceleration is linear from a0 to a1.
struct Cubic {
  double q0, v0, q1, v1, h, a0, a1;

  Cubic(const TimedPath& path, std::size_t i, Eigen::Index j)
      : q0(path.q[i][j]),
        v0(path.qd[i][j]),
        q1(path.q[i + 1][j]),
        v1(path.qd[i + 1][j]),
        h(path.t[i + 1] - path.t[i]) {
    const double mean = (q1 - q0) / h;
    a0 = (6 * mean - 4 * v0 - 2 * v1) / h;
    a1 = (-6 * mean + 2 * v0 + 4 * v1) / h;
  }

  double position(double tau) const {
    return q0 + tau * (v0 + tau * (0.5 * a0 + tau * (a1 - a0) / (6 * h)));
  }

  double velocity(double tau) const { return v0 + tau * (a0 + 0.5 * tau * (a1 - a0) / h); }

  double greatestSpeed() const {
    double speed = std::max(std::abs(v0), std::abs(v1));
    if (a0 * a1 < 0) speed = std::max(speed, std::abs(v0 + 0.5 * a0 * (h * a0 / (a0 - a1))));
    return speed;
  }

  // Greatest excess beyond [lower, upper].
  double excess(double lower, double upper) const {
    const auto beyond = [&](double q) { return std::max(lower - q, q - upper); };
    const double ends = std::max(beyond(q0), beyond(q1));
    // The control points of the cubic enclose it.
    const double hull = std::max(beyond(q0 + v0 * h / 3), beyond(q1 - v1 * h / 3));
    if (hull <= ends) return ends;
    double worst = ends;
    const double a = 0.5 * (a1 - a0) / h;  // velocity = a tau^2 + a0 tau + v0
    const double discriminant = a0 * a0 - 4 * a * v0;
    if (discriminant < 0) return worst;
    const double p = -0.5 * (a0 + std::copysign(std::sqrt(discriminant), a0));
    for (const double tau : {p / a, v0 / p}) {
      if (tau > 0 && tau < h) worst = std::max(worst, beyond(position(tau)));
    }
    return worst;
  }
};

void stretchTime(TimedPath& path, double factor) {
  for (double& t : path.t) t *= factor;
  for (VectorXd& qd : path.qd) qd /= factor;
}

// Slows the whole curve until the limits hold for the numbers as they are; returns the factor.
double keepLimits(TimedPath& path, const TimingLimits& limits) {
  double stretch = 1;
  for (int round = 0; round < 20; ++round) {
    const LimitUse use = limitUse(path, limits);
    const double over = std::max(use.velocity, std::sqrt(use.acceleration));
    if (use.velocity <= 1 && use.acceleration <= 1) break;
    const double factor = over * (1 + 1e-12 * (1 << round));
    stretchTime(path, factor);
    stretch *= factor;
  }
  return stretch;
}

// Puts further samples on the same curve so that none are further apart than `gap`.
void fillGaps(TimedPath& path, double gap) {
  std::size_t count = 1;
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    count += static_cast<std::size_t>(std::max(1.0, std::ceil((path.t[i + 1] - path.t[i]) / gap)));
  }
  if (count == path.t.size()) return;
  TimedPath filled;
  filled.t.reserve(count);
  filled.q.reserve(count);
  filled.qd.reserve(count);
  const Eigen::Index dof = path.q.front().size();
  for (std::size_t i = 0; i < path.t.size(); ++i) {
    filled.t.push_back(path.t[i]);
    filled.q.push_back(std::move(path.q[i]));
    filled.qd.push_back(std::move(path.qd[i]));
    if (i + 1 == path.t.size()) break;
    path.q[i] = filled.q.back();
    path.qd[i] = filled.qd.back();
    const double dt = path.t[i + 1] - path.t[i];
    const int parts = static_cast<int>(std::max(1.0, std::ceil(dt / gap)));
    for (int k = 1; k < parts; ++k) {
      VectorXd q(dof), qd(dof);
      const double tau = dt * k / parts;
      for (Eigen::Index j = 0; j < dof; ++j) {
        const Cubic cubic(path, i, j);
        q[j] = cubic.position(tau);
        qd[j] = cubic.velocity(tau);
      }
      filled.t.push_back(path.t[i] + tau);
      filled.q.push_back(std::move(q));
      filled.qd.push_back(std::move(qd));
    }
  }
  path = std::move(filled);
}

// The first fault of the input, or an empty text.
std::string faultOf(const std::vector<VectorXd>& waypoints, const TimingLimits& limits,
                    const TimingSettings& settings) {
  if (waypoints.empty()) return "path: no waypoints";
  const Eigen::Index dof = waypoints.front().size();
  if (dof == 0) return "path: waypoints without joints";
  for (const VectorXd* v : {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration}) {
    if (v->size() != dof) return "limits: their number differs from the waypoints' joints";
  }
  for (Eigen::Index j = 0; j < dof; ++j) {
    const std::string joint = "limits of joint " + std::to_string(j);
    if (!(limits.lower[j] <= limits.upper[j])) return joint + ": lower is not below upper";
    if (!(limits.velocity[j] > 0)) return joint + ": velocity is not above 0";
    if (!(limits.acceleration[j] > 0) || !std::isfinite(limits.acceleration[j])) {
      return joint + ": acceleration is not above 0 and finite";
    }
  }
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const std::string point = "waypoint " + std::to_string(i);
    if (waypoints[i].size() != dof) return point + ": size differs from the first one's";
    for (Eigen::Index j = 0; j < dof; ++j) {
      const double q = waypoints[i][j];
      if (!std::isfinite(q)) return point + ": joint " + std::to_string(j) + " is not finite";
      if (q < limits.lower[j] - kPositionSlack || q > limits.upper[j] + kPositionSlack) {
        return point + ": joint " + std::to_string(j) + " is outside its limits";
      }
    }
  }
  if (!(settings.blend >= 0) || !std::isfinite(settings.blend)) return "blend: not >= 0";
  if (!(settings.max_sample_gap > 0)) return "max_sample_gap: not above 0";
  if (!(settings.speed_scale > 0 && settings.speed_scale <= 1)) return "speed_scale: not in (0, 1]";
  return "";
}

// Both ends as given, between them no two nearer than kMinSegment; one point if nothing moves.
std::vector<VectorXd> distinct(const std::vector<VectorXd>& waypoints) {
  std::vector<VectorXd> kept{waypoints.front()};
  for (const VectorXd& q : waypoints) {
    if ((q - kept.back()).norm() > kMinSegment) kept.push_back(q);
  }
  const VectorXd& last = waypoints.back();
  if (kept.back() == last) return kept;
  if (kept.size() > 1 && (last - kept.back()).norm() <= kMinSegment) kept.pop_back();
  kept.push_back(last);
  return kept;
}

}  // namespace

Result<TimedPath> parameterize(const std::vector<VectorXd>& waypoints, const TimingLimits& limits,
                               const TimingSettings& settings, double* stretch) {
  if (const std::string fault = faultOf(waypoints, limits, settings); !fault.empty()) {
    return {ErrorCode::kInvalidInput, fault};
  }
  if (stretch) *stretch = 1;
  const std::vector<VectorXd> points = distinct(waypoints);
  if (points.size() == 1) {
    const VectorXd rest = VectorXd::Zero(points[0].size());
    return TimedPath{{0, kRestDuration}, {waypoints.front(), waypoints.back()}, {rest, rest}};
  }
  TimedPath path;
  double slower = 1;
  for (int round = 0; round <= kRefinements; ++round) {
    const Grid grid = makeGrid(points, settings.blend, 1 << round);
    const SpeedProfile profile(grid, limits);
    path = {};
    if (!sample(grid, profile.x(), limits, path)) {
      return {ErrorCode::kInternal, "timing: the path cannot be passed at any speed"};
    }
    slower = keepLimits(path, limits);
    if (slower <= kGoodStretch && positionExcess(path, limits) <= kPositionSlack) break;
  }
  if (stretch) *stretch = slower;
  // At full speed: slowed a thousandfold, the path has the same samples and not a thousand times as
  // many.
  fillGaps(path, settings.max_sample_gap);
  if (settings.speed_scale < 1) stretchTime(path, 1 / settings.speed_scale);
  keepLimits(path, limits);
  return path;
}

TimedPath slowed(const TimedPath& path, double speed_scale) {
  TimedPath slow = path;
  stretchTime(slow, 1 / speed_scale);
  return slow;
}

void evaluate(const TimedPath& path, double t, VectorXd& q, VectorXd& qd) {
  q.resize(path.q.front().size());
  qd.resize(q.size());
  if (t <= 0 || path.t.size() == 1) {
    q = path.q.front();
    qd = path.qd.front();
    return;
  }
  if (t >= path.duration()) {
    q = path.q.back();
    qd = path.qd.back();
    return;
  }
  const auto after = std::upper_bound(path.t.begin(), path.t.end(), t);
  const auto i = static_cast<std::size_t>(after - path.t.begin()) - 1;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const Cubic cubic(path, i, j);
    q[j] = cubic.position(t - path.t[i]);
    qd[j] = cubic.velocity(t - path.t[i]);
  }
}

VectorXd evaluate(const TimedPath& path, double t) {
  VectorXd q, qd;
  evaluate(path, t, q, qd);
  return q;
}

LimitUse limitUse(const TimedPath& path, const TimingLimits& limits) {
  LimitUse use;
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    for (Eigen::Index j = 0; j < path.q[i].size(); ++j) {
      const Cubic cubic(path, i, j);
      use.velocity = std::max(use.velocity, cubic.greatestSpeed() / limits.velocity[j]);
      use.acceleration =
          std::max(use.acceleration,
                   std::max(std::abs(cubic.a0), std::abs(cubic.a1)) / limits.acceleration[j]);
    }
  }
  return use;
}

double positionExcess(const TimedPath& path, const TimingLimits& limits) {
  double worst = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path.t.size(); ++i) {
    for (Eigen::Index j = 0; j < path.q[i].size(); ++j) {
      worst = std::max(worst, Cubic(path, i, j).excess(limits.lower[j], limits.upper[j]));
    }
  }
  return worst;
}

}  // namespace handover
