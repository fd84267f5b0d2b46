// SPDX-License-Identifier: Apache-2.0
#include "core/collision/gjk.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace handover {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 1e-8;  // [m]
constexpr int kIterations = 100;     // curved cores take the most; hulls below 20

// Two vertices at a time, without branches that nothing can foresee.
std::size_t farthest(const HullCore& hull, const Vector3d& d) {
  const std::size_t count = hull.x.size();
#ifdef __SSE2__
  const __m128d dx = _mm_set1_pd(d.x()), dy = _mm_set1_pd(d.y()), dz = _mm_set1_pd(d.z());
  __m128d most = _mm_set1_pd(-std::numeric_limits<double>::infinity());
  __m128d at = _mm_setzero_pd(), here = _mm_set_pd(1, 0);
  for (std::size_t i = 0; i < count; i += 2) {
    const __m128d along = _mm_add_pd(_mm_add_pd(_mm_mul_pd(_mm_loadu_pd(&hull.x[i]), dx),
                                                _mm_mul_pd(_mm_loadu_pd(&hull.y[i]), dy)),
                                     _mm_mul_pd(_mm_loadu_pd(&hull.z[i]), dz));
    const __m128d better = _mm_cmpgt_pd(along, most);
    most = _mm_max_pd(along, most);
    at = _mm_or_pd(_mm_and_pd(better, here), _mm_andnot_pd(better, at));
    here = _mm_add_pd(here, _mm_set1_pd(2));
  }
  const bool second = _mm_cvtsd_f64(_mm_unpackhi_pd(most, most)) > _mm_cvtsd_f64(most);
  return static_cast<std::size_t>(_mm_cvtsd_f64(second ? _mm_unpackhi_pd(at, at) : at));
#else
  std::size_t best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    const double along = hull.x[i] * d.x() + hull.y[i] * d.y() + hull.z[i] * d.z();
    if (along > most) {
      most = along;
      best = i;
    }
  }
  return best;
#endif
}

struct SupportOf {
  const Vector3d& d;

  Vector3d operator()(const BoxCore& box) const {
    return {std::copysign(box.half.x(), d.x()), std::copysign(box.half.y(), d.y()),
            std::copysign(box.half.z(), d.z())};
  }

  Vector3d operator()(const CylinderCore& cylinder) const {
    const double across = std::sqrt(d.x() * d.x() + d.y() * d.y());
    const double scale = across > 0 ? cylinder.radius / across : 0;
    return {d.x() * scale, d.y() * scale, std::copysign(cylinder.half_length, d.z())};
  }

  Vector3d operator()(const PointCore&) const { return Vector3d::Zero(); }

  Vector3d operator()(const TriangleCore& triangle) const {
    const double a = triangle.corners[0].dot(d), b = triangle.corners[1].dot(d),
                 c = triangle.corners[2].dot(d);
    return triangle.corners[a >= b ? (a >= c ? 0 : 2) : (b >= c ? 1 : 2)];
  }

  Vector3d operator()(const HullCore& hull) const {
    const std::size_t best = farthest(hull, d);
    return {hull.x[best], hull.y[best], hull.z[best]};
  }
};

Vector3d middleOf(const ConvexCore& core) {
  if (const auto* hull = std::get_if<HullCore>(&core)) return hull->middle;
  const auto* triangle = std::get_if<TriangleCore>(&core);
  if (triangle == nullptr) return Vector3d::Zero();
  return (triangle->corners[0] + triangle->corners[1] + triangle->corners[2]) / 3;
}

struct CoreOf {
  ConvexCore operator()(const BoxShape& box) const { return BoxCore{0.5 * box.size}; }

  ConvexCore operator()(const SphereShape&) const { return PointCore{}; }

  ConvexCore operator()(const CylinderShape& cylinder) const {
    return CylinderCore{cylinder.radius, 0.5 * cylinder.length};
  }

  ConvexCore operator()(const ConvexShape& convex) const {
    HullCore hull;
    hull.middle.setZero();
    const auto add = [&](const Vector3d& v) {
      hull.x.push_back(v.x());
      hull.y.push_back(v.y());
      hull.z.push_back(v.z());
    };
    for (const Vector3d& v : convex.vertices) {
      hull.middle += v / static_cast<double>(convex.vertices.size());
      add(v);
    }
    if (convex.vertices.size() % 2 != 0) add(convex.vertices.back());
    return hull;
  }
};

// A point of the Minkowski difference A - B, with where it comes from.
struct Vertex {
  Vector3d w, p_Wa, p_Wb;
};

struct Simplex {
  std::array<Vertex, 4> vertices;
  std::array<double, 4> weights{};
  int size = 0;
};

// The point of a simplex that is nearest to the origin, as weights of the vertices used.
struct Nearest {
  Vector3d v;
  double squared = std::numeric_limits<double>::infinity();
  std::array<double, 4> weights{};

  void consider(const Vector3d& point, std::array<double, 4> by) {
    const double square = point.squaredNorm();
    if (square >= squared) return;
    v = point;
    squared = square;
    weights = by;
  }
};

void nearestOfVertex(const Simplex& s, int i, Nearest& best) {
  std::array<double, 4> weights{};
  weights[static_cast<std::size_t>(i)] = 1;
  best.consider(s.vertices[static_cast<std::size_t>(i)].w, weights);
}

// Only the inside of the edge: its ends are considered by themselves.
void nearestOfEdge(const Simplex& s, int i, int j, Nearest& best) {
  const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
  const Vector3d edge = s.vertices[b].w - s.vertices[a].w;
  const double length2 = edge.squaredNorm();
  const double along = -s.vertices[a].w.dot(edge);
  if (along <= 0 || along >= length2) return;
  std::array<double, 4> weights{};
  weights[b] = along / length2;
  weights[a] = 1 - weights[b];
  best.consider(s.vertices[a].w + weights[b] * edge, weights);
}

void nearestOfTriangle(const Simplex& s, int i, int j, int k, Nearest& best) {
  const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j),
             c = static_cast<std::size_t>(k);
  const Vector3d &A = s.vertices[a].w, &B = s.vertices[b].w, &C = s.vertices[c].w;
  const Vector3d normal = (B - A).cross(C - A);
  const double area2 = normal.squaredNorm();
  if (area2 == 0) return;
  const double u = normal.dot(B.cross(C)), v = normal.dot(C.cross(A)), w = normal.dot(A.cross(B));
  if (u < 0 || v < 0 || w < 0) return;
  std::array<double, 4> weights{};
  weights[a] = u / area2;
  weights[b] = v / area2;
  weights[c] = w / area2;
  best.consider(normal * (normal.dot(A) / area2), weights);
}

double volume(const Vector3d& a, const Vector3d& b, const Vector3d& c) { return a.dot(b.cross(c)); }

// True when the origin is inside; the weights then are its barycentric coordinates.
bool originInside(const Simplex& s, std::array<double, 4>& weights) {
  const Vector3d &A = s.vertices[0].w, &B = s.vertices[1].w, &C = s.vertices[2].w,
                 &D = s.vertices[3].w;
  const double whole = volume(B - A, C - A, D - A);
  const std::array<double, 4> parts{volume(B, C, D), -volume(A, C, D), volume(A, B, D),
                                    -volume(A, B, C)};
  if (whole == 0) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    weights[i] = parts[i] / whole;
    if (!(weights[i] >= 0)) return false;
  }
  return true;
}

// All faces, edges and vertices are looked at, so that flat simplices do no harm; those that cannot
// hold the nearest point (they lack the vertex just added) have been beaten already.
Nearest nearestPoint(const Simplex& s) {
  Nearest best;
  const int last = s.size - 1;
  nearestOfVertex(s, last, best);
  for (int i = 0; i < last; ++i) {
    nearestOfEdge(s, i, last, best);
    for (int j = i + 1; j < last; ++j) nearestOfTriangle(s, i, j, last, best);
  }
  return best;
}

void keepUsed(Simplex& s, const std::array<double, 4>& weights) {
  int kept = 0;
  for (int i = 0; i < s.size; ++i) {
    const auto from = static_cast<std::size_t>(i), to = static_cast<std::size_t>(kept);
    if (!(weights[from] > 0)) continue;
    s.vertices[to] = s.vertices[from];
    s.weights[to] = weights[from];
    ++kept;
  }
  s.size = kept;
}

void setPoints(const Simplex& s, GjkResult& result) {
  result.p_Wa.setZero();
  result.p_Wb.setZero();
  for (int i = 0; i < s.size; ++i) {
    const auto at = static_cast<std::size_t>(i);
    result.p_Wa += s.weights[at] * s.vertices[at].p_Wa;
    result.p_Wb += s.weights[at] * s.vertices[at].p_Wb;
  }
}

// The least of n.p over the core's points p and those of balls about them, as the core goes by
// x * twist, to first order: a plane's turned the other way round.
double leastAlong(const ConvexCore& core, const Eigen::Isometry3d& X_W, double radius,
                  const Twist& twist, double x, const Vector3d& n) {
  const Vector3d d = n + x * n.cross(twist.w);
  const double least = d.dot(X_W * supportPoint(core, X_W.linear().transpose() * -d));
  return least + x * n.dot(twist.v) - (radius > 0 ? radius * d.norm() : 0);
}

// Whether the plane across `towards_a` leaves enough at both ends of the motion. In between it
// leaves more: what is least along a direction is concave in x.
bool leavesEnough(const ConvexCore& a, const Eigen::Isometry3d& X_WA, const ConvexCore& b,
                  const Eigen::Isometry3d& X_WB, const Vector3d& towards_a, const GjkSweep& sweep) {
  const Vector3d n = towards_a.normalized();
  const double enough = sweep.clearance + sweep.motion.beyond;
  for (const double x : {-1.0, 1.0}) {
    const double gap = leastAlong(a, X_WA, sweep.radius_a, sweep.motion.a, x, n) +
                       leastAlong(b, X_WB, sweep.radius_b, sweep.motion.b, x, -n);
    if (!(gap > enough)) return false;
  }
  return true;
}

/// One question to gjk(): the simplex so far, whose nearest point to the origin is v.
class Search {
 public:
  Search(const ConvexCore& a, const Eigen::Isometry3d& X_WA, const ConvexCore& b,
         const Eigen::Isometry3d& X_WB, double enough, double near, const GjkSweep* sweep,
         GjkResult& result)
      : a_(a),
        X_WA_(X_WA),
        b_(b),
        X_WB_(X_WB),
        enough_(enough),
        near_(near),
        sweep_(sweep),
        swept_(!sweep
                   ? 0
                   : sweep->radius_a + sweep->radius_b + sweep->clearance + sweep->motion.beyond),
        result_(result) {}

  void run() {
    if (toldByMiddles()) return;
    for (int i = 0; i < kIterations; ++i) {
      if (closeEnough()) break;
      const Vertex added = support(-v_);
      if (toldByPlane(added) || !comesNearer(added)) break;
    }
    if (result_.overlap) result_.at_least = result_.at_most = 0;
    setPoints(simplex_, result_);
  }

 private:
  Vertex support(const Vector3d& d) const {
    Vertex vertex;
    vertex.p_Wa = X_WA_ * supportPoint(a_, X_WA_.linear().transpose() * d);
    vertex.p_Wb = X_WB_ * supportPoint(b_, X_WB_.linear().transpose() * -d);
    vertex.w = vertex.p_Wa - vertex.p_Wb;
    return vertex;
  }

  bool staysApart(const Vector3d& towards_a) const {
    return leavesEnough(a_, X_WA_, b_, X_WB_, towards_a, *sweep_);
  }

  /// Begins with the line of the middles, which often tells already.
  bool toldByMiddles() {
    Vector3d start = X_WA_ * middleOf(a_) - X_WB_ * middleOf(b_);
    if (start.squaredNorm() < 1e-12) start = Vector3d::UnitX();
    simplex_.vertices[0] = support(-start);
    simplex_.weights[0] = 1;
    simplex_.size = 1;
    v_ = simplex_.vertices[0].w;
    result_.at_least = std::max(0.0, start.dot(v_) / start.norm());
    if (result_.at_least > enough_) return true;
    result_.swept_free = sweep_ && result_.at_least > std::max(near_, swept_) && staysApart(start);
    return result_.swept_free;
  }

  /// v tells enough as it is.
  bool closeEnough() {
    result_.at_most = v_.norm();
    if (result_.at_most < kTolerance) {
      result_.overlap = true;
      return true;
    }
    result_.towards_a_W = v_;
    if (result_.at_most <= near_) return true;
    return sweep_ && result_.at_least > near_ &&
           (result_.at_most <= swept_ || result_.at_least > sweep_->agreeing * result_.at_most);
  }

  /// The plane across v at the vertex farthest that way tells enough.
  bool toldByPlane(const Vertex& added) {
    const double least = v_.dot(added.w) / result_.at_most;
    if (sweep_ && least > std::max({near_, swept_, result_.at_least}) && staysApart(v_)) {
      result_.swept_free = true;
    }
    result_.at_least = std::max(result_.at_least, least);
    return result_.swept_free || result_.at_least > enough_ ||
           result_.at_most - result_.at_least < kTolerance;
  }

  /// Takes the vertex in. False when the origin is inside, or rounding prevents progress.
  bool comesNearer(const Vertex& added) {
    Simplex next = simplex_;
    next.vertices[static_cast<std::size_t>(next.size++)] = added;
    std::array<double, 4> inside{};
    if (next.size == 4 && originInside(next, inside)) {
      simplex_ = next;
      simplex_.weights = inside;
      result_.overlap = true;
      return false;
    }
    const Nearest nearest = nearestPoint(next);
    if (nearest.squared >= v_.squaredNorm()) return false;
    keepUsed(next, nearest.weights);
    simplex_ = next;
    v_ = nearest.v;
    return true;
  }

  const ConvexCore& a_;
  const Eigen::Isometry3d& X_WA_;
  const ConvexCore& b_;
  const Eigen::Isometry3d& X_WB_;
  const double enough_, near_;
  const GjkSweep* sweep_;
  const double swept_;  ///< what the sweep asks for at least [m]
  GjkResult& result_;
  Simplex simplex_;
  Vector3d v_;
};

}  // namespace

Vector3d supportPoint(const ConvexCore& core, const Vector3d& direction) {
  return std::visit(SupportOf{direction}, core);
}

RoundedCore coreOf(const Shape& shape) {
  RoundedCore rounded{std::visit(CoreOf{}, shape.geometry), 0};
  if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) {
    rounded.radius = sphere->radius;
  }
  return rounded;
}

GjkResult gjk(const ConvexCore& a, const Eigen::Isometry3d& X_WA, const ConvexCore& b,
              const Eigen::Isometry3d& X_WB, double enough, double near, const GjkSweep* sweep) {
  GjkResult result;
  Search(a, X_WA, b, X_WB, enough, near, sweep, result).run();
  return result;
}

}  // namespace handover
