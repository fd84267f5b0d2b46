// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/wrench_quality.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace handover {
namespace {

constexpr int kConeEdges = 8;
constexpr int kDirections = 256;
constexpr int kDescents = 12;
constexpr int kDescentSteps = 80;

/// The fixed directions: normal deviates of a splitmix sequence, each with its opposite.
std::vector<Wrench> fixedDirections() {
  std::vector<Wrench> directions;
  std::uint64_t state = 0x9e3779b97f4a7c15ULL;
  const auto uniform = [&state] {
    state += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
  };
  while (static_cast<int>(directions.size()) < kDirections) {
    Wrench u;
    for (int i = 0; i < 6; ++i) {
      u[i] = std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * M_PI * uniform());
    }
    u.normalize();
    directions.push_back(u);
    directions.push_back(-u);
  }
  return directions;
}

using WrenchMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Support function of the hull in direction u, and the wrench that attains it.
std::pair<double, Eigen::Index> support(const WrenchMatrix& hull, const Wrench& u) {
  Eigen::Index best = 0;
  const double value = (u.transpose() * hull).maxCoeff(&best);
  return {value, best};
}

/// Walks on the unit sphere against the subgradient, ever shorter; the least value seen.
double descend(const WrenchMatrix& hull, Wrench u) {
  auto [value, at] = support(hull, u);
  double least = value;
  for (int k = 0; k < kDescentSteps; ++k) {
    Wrench tangent = hull.col(at) - value * u;
    const double length = tangent.norm();
    if (length < 1e-12) break;
    u = (u - (0.3 * std::pow(0.94, k) / length) * tangent).normalized();
    std::tie(value, at) = support(hull, u);
    least = std::min(least, value);
  }
  return least;
}

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

double largestBall(const std::vector<Wrench>& wrenches) {
  if (wrenches.empty()) return 0.0;
  WrenchMatrix hull(6, static_cast<Eigen::Index>(wrenches.size()));
  for (std::size_t i = 0; i < wrenches.size(); ++i)
    hull.col(static_cast<Eigen::Index>(i)) = wrenches[i];
  static const std::vector<Wrench> kFixed = fixedDirections();
  std::vector<Wrench> directions = kFixed;
  // Where the wrenches span little, the ball is small: their own thin directions.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(hull * hull.transpose());
  for (int i = 0; i < 6; ++i) {
    directions.push_back(eigen.eigenvectors().col(i));
    directions.push_back(-eigen.eigenvectors().col(i));
  }
  const Wrench mean = hull.rowwise().mean();
  if (mean.norm() > 1e-12) directions.push_back(-mean.normalized());

  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    order.emplace_back(support(hull, directions[i]).first, i);
  }
  std::sort(order.begin(), order.end());
  double least = order.front().first;
  for (std::size_t k = 0; k < std::min<std::size_t>(kDescents, order.size()); ++k) {
    least = std::min(least, descend(hull, directions[order[k].second]));
  }
  return least;
}

}  // namespace handover
