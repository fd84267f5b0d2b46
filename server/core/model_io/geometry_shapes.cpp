// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/geometry_shapes.hpp"

#include "core/model_io/mesh_reader.hpp"

namespace handover {
namespace {

Eigen::Vector3d vectorOf(const std::array<double, 3>& xyz) { return {xyz[0], xyz[1], xyz[2]}; }

Shape atOrigin(std::variant<BoxShape, SphereShape, CylinderShape, ConvexShape> geometry) {
  return Shape{Pose::Identity(), std::move(geometry)};
}

struct ShapeMaker {
  const std::filesystem::path& root;
  const ConvexDecomposer& divide;

  std::vector<Shape> operator()(const BoxGeometry& box) const {
    return {atOrigin(BoxShape{vectorOf(box.size)})};
  }

  std::vector<Shape> operator()(const SphereGeometry& sphere) const {
    return {atOrigin(SphereShape{sphere.radius})};
  }

  std::vector<Shape> operator()(const CylinderGeometry& cylinder) const {
    return {atOrigin(CylinderShape{cylinder.radius, cylinder.length})};
  }

  std::vector<Shape> operator()(const MeshGeometry& mesh) const {
    return readConvexMesh(root / mesh.path, vectorOf(mesh.scale), divide);
  }

  std::vector<Shape> operator()(const CompoundGeometry& compound) const {
    std::vector<Shape> shapes;
    for (const GeometryPart& part : compound.parts) {
      const Pose X_OS = toPose(part.X_OS);
      for (Shape& shape : shapesOf(part.geometry, root, divide)) {
        shape.X_BS = X_OS * shape.X_BS;
        shapes.push_back(std::move(shape));
      }
    }
    return shapes;
  }
};

}  // namespace

std::vector<Shape> shapesOf(const Geometry& geometry, const std::filesystem::path& root,
                            const ConvexDecomposer& divide) {
  return std::visit(ShapeMaker{root, divide}, geometry);
}

}  // namespace handover
