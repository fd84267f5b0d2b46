// SPDX-License-Identifier: Apache-2.0
#include "random_shapes.hpp"

namespace handover::test {

double RandomShapes::uniform(double lower, double upper) {
  return lower + (upper - lower) * (static_cast<double>(random_() >> 11) * 0x1.0p-53);
}

Eigen::Vector3d RandomShapes::direction() {
  for (;;) {
    const Eigen::Vector3d v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    const double length = v.norm();
    if (length > 0.1 && length < 1) return v / length;
  }
}

Pose RandomShapes::pose(double reach) {
  Pose X = Pose::Identity();
  X.linear() = Eigen::AngleAxisd(uniform(0, 3.14159), direction()).toRotationMatrix();
  X.translation() =
      Eigen::Vector3d(uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach));
  return X;
}

BoxShape RandomShapes::box() {
  return {Eigen::Vector3d(uniform(0.004, 0.4), uniform(0.004, 0.4), uniform(0.004, 0.4))};
}

SphereShape RandomShapes::sphere() { return {uniform(0.005, 0.2)}; }

CylinderShape RandomShapes::cylinder() { return {uniform(0.005, 0.15), uniform(0.005, 0.4)}; }

ConvexShape RandomShapes::hull() {
  const int count = 4 + static_cast<int>(uniform(0, 20.999));
  const Eigen::Vector3d radii(uniform(0.02, 0.2), uniform(0.02, 0.2), uniform(0.02, 0.2));
  const Eigen::Vector3d middle = 0.1 * direction();
  ConvexShape shape;
  for (int i = 0; i < count; ++i) {
    shape.vertices.push_back(middle + direction().cwiseProduct(radii));
  }
  shape.triangles = hullTriangles(shape.vertices);
  return shape;
}

Shape RandomShapes::any() {
  Shape shape;
  const double kind = uniform(0, 4);
  if (kind < 1) {
    shape.geometry = box();
  } else if (kind < 1.5) {
    shape.geometry = sphere();
  } else if (kind < 2.5) {
    shape.geometry = cylinder();
  } else {
    shape.geometry = hull();
  }
  return shape;
}

std::vector<std::array<int, 3>> hullTriangles(const std::vector<Eigen::Vector3d>& points) {
  std::vector<std::array<int, 3>> triangles;
  const int n = static_cast<int>(points.size());
  const auto at = [&](int i) -> const Eigen::Vector3d& {
    return points[static_cast<std::size_t>(i)];
  };
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      for (int k = j + 1; k < n; ++k) {
        const Eigen::Vector3d normal = (at(j) - at(i)).cross(at(k) - at(i));
        int above = 0, below = 0;
        for (int p = 0; p < n; ++p) {
          if (p == i || p == j || p == k) continue;
          (normal.dot(at(p) - at(i)) > 0 ? above : below) += 1;
        }
        if (above == 0)
          triangles.push_back({i, j, k});
        else if (below == 0)
          triangles.push_back({i, k, j});
      }
    }
  }
  return triangles;
}

}  // namespace handover::test
