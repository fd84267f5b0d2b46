// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/wrench_quality.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace handover {
namespace {

constexpr int kConeEdges = 8;
constexpr double kJoggle =
    1e-7;  // breaks ties of points in one plane; far below any quality of use
constexpr std::size_t kMaxFacets = 20000;

using Corners = std::array<int, 6>;
using Ridge = std::array<int, 5>;

struct Facet {
  Corners corners;     // ascending
  Wrench normal;       // unit, outward
  double offset = 0;   // normal . x <= offset inside
  double support = 0;  // of all points along the normal: >= offset
  int farthest = -1;   // the point there
};

/// A polytope inside the hull that grows where it is nearest to the origin: the expanding polytope
/// of collision detection, in six dimensions.
class ExpandingPolytope {
 public:
  explicit ExpandingPolytope(const std::vector<Wrench>& wrenches)
      : points_(6, static_cast<Eigen::Index>(wrenches.size())) {
    std::uint64_t state = 0x9e3779b97f4a7c15ULL;
    for (Eigen::Index i = 0; i < points_.cols(); ++i) {
      for (int k = 0; k < 6; ++k) {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        const double deviate = static_cast<double>(state >> 33) / 2147483648.0 - 0.5;
        points_(k, i) = wrenches[static_cast<std::size_t>(i)][k] + 2.0 * kJoggle * deviate;
      }
    }
  }

  double grow(double enough) {
    if (points_.cols() < 7 || !startSimplex()) return 0.0;
    while (true) {
      const auto nearest =
          std::min_element(facets_.begin(), facets_.end(),
                           [](const Facet& a, const Facet& b) { return a.offset < b.offset; });
      if (nearest->support <= 0) return nearest->support;  // all wrenches are on one side
      if (nearest->offset >= enough * nearest->support) return nearest->offset;
      if (facets_.size() > kMaxFacets) return nearest->offset;
      if (!add(nearest->farthest)) return nearest->offset;
    }
  }

 private:
  Facet facet(Corners corners) const {
    std::sort(corners.begin(), corners.end());
    Facet f;
    f.corners = corners;
    Eigen::Matrix<double, 6, 5> edges;
    for (int k = 0; k < 5; ++k) {
      edges.col(k) =
          points_.col(corners[static_cast<std::size_t>(k) + 1]) - points_.col(corners[0]);
    }
    const Eigen::HouseholderQR<Eigen::Matrix<double, 6, 5>> qr(edges);
    f.normal = qr.householderQ() * Wrench::Unit(5);
    if (f.normal.dot(inside_ - points_.col(corners[0])) > 0) f.normal = -f.normal;
    f.offset = f.normal.dot(points_.col(corners[0]));
    Eigen::Index at = 0;
    f.support = (f.normal.transpose() * points_).maxCoeff(&at);
    f.farthest = static_cast<int>(at);
    return f;
  }

  /// Seven points, each as far as can be from the flat through those before it.
  bool startSimplex() {
    std::array<int, 7> simplex{};
    Eigen::Index first = 0;
    points_.row(0).maxCoeff(&first);
    simplex[0] = static_cast<int>(first);
    Eigen::Matrix<double, 6, Eigen::Dynamic> rest = points_.colwise() - points_.col(first);
    for (std::size_t k = 1; k < 7; ++k) {
      Eigen::Index at = 0;
      if (rest.colwise().squaredNorm().maxCoeff(&at) < 1e-24) return false;
      simplex[k] = static_cast<int>(at);
      const Wrench along = rest.col(at).normalized();
      rest -= along * (along.transpose() * rest).eval();
    }
    inside_.setZero();
    for (const int corner : simplex) inside_ += points_.col(corner) / 7.0;
    for (std::size_t left_out = 0; left_out < 7; ++left_out) {
      Corners corners{};
      for (std::size_t k = 0, c = 0; k < 7; ++k) {
        if (k != left_out) corners[c++] = simplex[k];
      }
      facets_.push_back(facet(corners));
    }
    return true;
  }

  /// Joins a point to all ridges between the facets it sees and those it does not. False: it sees
  /// none.
  bool add(int point) {
    std::vector<Ridge> ridges;
    std::vector<Facet> kept;
    for (const Facet& f : facets_) {
      if (f.normal.dot(points_.col(point)) <= f.offset + 1e-13) {
        kept.push_back(f);
        continue;
      }
      for (std::size_t left_out = 0; left_out < 6; ++left_out) {
        Ridge ridge{};
        for (std::size_t k = 0, c = 0; k < 6; ++k) {
          if (k != left_out) ridge[c++] = f.corners[k];
        }
        ridges.push_back(ridge);
      }
    }
    if (ridges.empty()) return false;
    std::sort(ridges.begin(), ridges.end());
    for (std::size_t i = 0; i < ridges.size();) {
      std::size_t next = i + 1;
      while (next < ridges.size() && ridges[next] == ridges[i]) ++next;
      if (next == i + 1) {
        const Ridge& r = ridges[i];
        kept.push_back(facet({r[0], r[1], r[2], r[3], r[4], point}));
      }
      i = next;
    }
    facets_ = std::move(kept);
    return true;
  }

  Eigen::Matrix<double, 6, Eigen::Dynamic> points_;
  Wrench inside_ = Wrench::Zero();
  std::vector<Facet> facets_;
};

}  // namespace

std::vector<Wrench> contactWrenches(const std::vector<ContactPoint>& contacts,
                                    const Eigen::Vector3d& centre, double size,
                                    const ContactModel& model) {
  std::vector<Wrench> wrenches;
  for (const ContactPoint& contact : contacts) {
    const Eigen::Vector3d push = -contact.n;
    const Eigen::Vector3d arm = contact.p - centre;
    const Eigen::Vector3d t = push.unitOrthogonal();
    const Eigen::Vector3d s = push.cross(t);
    const auto add = [&](const Eigen::Vector3d& force, double normal_moment) {
      Wrench w;
      w << force, (arm.cross(force) + normal_moment * push) / size;
      wrenches.push_back(w);
    };
    for (int e = 0; e < kConeEdges; ++e) {
      const double angle = 2.0 * M_PI * e / kConeEdges;
      add(push + model.friction * (std::cos(angle) * t + std::sin(angle) * s), 0.0);
    }
    add(push, model.friction * model.patch_radius);
    add(push, -model.friction * model.patch_radius);
  }
  return wrenches;
}

double largestBall(const std::vector<Wrench>& wrenches, double enough) {
  return ExpandingPolytope(wrenches).grow(enough);
}

}  // namespace handover
