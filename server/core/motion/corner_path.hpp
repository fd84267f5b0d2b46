// SPDX-License-Identifier: Apache-2.0
// A joint polyline whose corners are rounded by parabolas, cut into cells for its timing.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace handover {

/// How the corner at a waypoint is rounded.
struct Corner {
  double at = 0;    ///< the polyline's length up to it [rad]
  double half = 0;  ///< of the parabola, before and after the corner [rad]; 0: the path stops there
  double turn = 0;  ///< |change of the unit direction|
};

/// One corner per point, the two ends' with half = 0. The parabola passes its corner at a distance
/// of at most `blend`. @pre no two successive points are equal.
std::vector<Corner> roundCorners(const std::vector<Eigen::VectorXd>& points, double blend);

/// In cell i, q_ss is constant and q_s goes linearly from q_s[i] to q_s[i + 1], so with u = s''
/// constant the acceleration q_ss x + q_s u (x = s'^2) is linear in s and has its extremes at the
/// cell's ends.
struct CornerPath {
  std::size_t dof = 0;
  std::vector<double> ds;         ///< per cell
  std::vector<double> curvature;  ///< q_ss, dof per cell
  std::vector<char> straight;     ///< per cell: q_ss = 0
  std::vector<double> q, q_s;     ///< dof per point

  std::size_t cells() const { return ds.size(); }
};

/// The whole path, about a hundred cells and some more for its corners.
/// @pre corners of these points; no inner one is a stop.
CornerPath cutIntoCells(const std::vector<Eigen::VectorXd>& points,
                        const std::vector<Corner>& corners);

}  // namespace handover
