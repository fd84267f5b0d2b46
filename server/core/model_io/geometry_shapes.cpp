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
  MeshImporter& importer;

  BodyShapes operator()(const BoxGeometry& box) const {
    return {{atOrigin(BoxShape{vectorOf(box.size)})}, {}};
  }

  BodyShapes operator()(const SphereGeometry& sphere) const {
    return {{atOrigin(SphereShape{sphere.radius})}, {}};
  }

  BodyShapes operator()(const CylinderGeometry& cylinder) const {
    return {{atOrigin(CylinderShape{cylinder.radius, cylinder.length})}, {}};
  }

  BodyShapes operator()(const MeshGeometry& mesh) const {
    return readMeshBodies(root / mesh.path, vectorOf(mesh.scale), divide, importer);
  }

  BodyShapes operator()(const CompoundGeometry& compound) const {
    BodyShapes whole;
    for (const GeometryPart& part : compound.parts) {
      append(bodyShapesOf(part.geometry, root, divide, importer), toPose(part.X_OS), whole);
    }
    return whole;
  }
};

}  // namespace

BodyShapes bodyShapesOf(const Geometry& geometry, const std::filesystem::path& root,
                        const ConvexDecomposer& divide) {
  MeshImporter importer;
  return bodyShapesOf(geometry, root, divide, importer);
}

BodyShapes bodyShapesOf(const Geometry& geometry, const std::filesystem::path& root,
                        const ConvexDecomposer& divide, MeshImporter& importer) {
  return std::visit(ShapeMaker{root, divide, importer}, geometry);
}

void append(BodyShapes part, const Pose& X_WholePart, BodyShapes& whole) {
  const int first = static_cast<int>(whole.shapes.size());
  for (Shape& shape : part.shapes) {
    shape.X_BS = X_WholePart * shape.X_BS;
    whole.shapes.push_back(std::move(shape));
  }
  for (DividedBody& body : part.divided) {
    for (Eigen::Vector3d& vertex : body.surface.vertices) vertex = X_WholePart * vertex;
    body.first_shape += first;
    whole.divided.push_back(std::move(body));
  }
}

}  // namespace handover
