// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/mesh_reader.hpp"

#include "core/decomposition/decomposition_file.hpp"
#include "core/decomposition/surface_bodies.hpp"
#include "core/model_io/file_fault.hpp"
#include "core/model_io/file_text.hpp"
#include "core/model_io/mesh_checker.hpp"
#include "core/model_io/mesh_import.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <system_error>
#include <unordered_map>

namespace handover {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxMib = 64;
constexpr std::uintmax_t kMaxTotalMib = 512;
/// Of a part that is taken as it is, after merging. A hull of more vertices is of no use to
/// collision checking, and the test of every vertex against every face stays below a second.
constexpr std::size_t kMaxPartVertices = 8192;
constexpr double kMergeDistance = 1e-7;    // [m]
constexpr double kConvexTolerance = 1e-4;  // [m], of bodies up to 1 m; relative to the size above
constexpr double kFlat = 1.7e-10;          // volume over size cubed: no solid
/// Planes of thinner triangles than this are noise.
constexpr double kMinTriangleHeight = 1e-5;  // [m]

[[noreturn]] void refuse(const fs::path& file, const std::string& message) {
  throw FileError({{file.string(), 0, message}});
}

/// Gives one place to points that lie within kMergeDistance of each other, first come first kept.
class PlaceMerger {
 public:
  Eigen::Vector3d placeOf(const Eigen::Vector3d& p) {
    const Cell cell = cellOf(p);
    // Most points come several times, exactly the same.
    if (const Eigen::Vector3d* known = lookUp(cell, p)) return *known;
    for (long dx = -1; dx <= 1; ++dx) {
      for (long dy = -1; dy <= 1; ++dy) {
        for (long dz = -1; dz <= 1; ++dz) {
          const Eigen::Vector3d* known = lookUp({cell[0] + dx, cell[1] + dy, cell[2] + dz}, p);
          if (known != nullptr) return *known;
        }
      }
    }
    cells_[cell].push_back(p);
    return p;
  }

 private:
  using Cell = std::array<long, 3>;

  struct CellHash {
    std::size_t operator()(const Cell& cell) const {
      std::size_t hash = 0;
      for (const long k : cell) {
        hash = (hash ^ static_cast<std::size_t>(k)) * 0x9E3779B97F4A7C15;
        hash ^= hash >> 29;
      }
      return hash;
    }
  };

  static Cell cellOf(const Eigen::Vector3d& p) {
    return {std::lround(p.x() / kMergeDistance), std::lround(p.y() / kMergeDistance),
            std::lround(p.z() / kMergeDistance)};
  }

  const Eigen::Vector3d* lookUp(const Cell& cell, const Eigen::Vector3d& p) const {
    const auto found = cells_.find(cell);
    if (found == cells_.end()) return nullptr;
    for (const Eigen::Vector3d& known : found->second) {
      if ((known - p).norm() <= kMergeDistance) return &known;
    }
    return nullptr;
  }

  std::unordered_map<Cell, std::vector<Eigen::Vector3d>, CellHash> cells_;
};

Eigen::Vector3d vertexAt(const ConvexShape& shape, int index) {
  return shape.vertices[static_cast<std::size_t>(index)];
}

double extentOf(const ConvexShape& shape) {
  Eigen::Vector3d low = shape.vertices.front(), high = low;
  for (const Eigen::Vector3d& v : shape.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return (high - low).norm();
}

/// How far the worst vertex stands out of the worst face's plane [m].
double worstBulge(const ConvexShape& shape) {
  double worst = 0;
  for (const auto& t : shape.triangles) {
    const Eigen::Vector3d a = vertexAt(shape, t[0]), b = vertexAt(shape, t[1]),
                          c = vertexAt(shape, t[2]);
    const Eigen::Vector3d area = (b - a).cross(c - a);
    const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
    if (area.norm() < kMinTriangleHeight * longest) continue;
    const Eigen::Vector3d normal = area.normalized();
    for (const Eigen::Vector3d& v : shape.vertices) worst = std::max(worst, normal.dot(v - a));
  }
  return worst;
}

/// Whether a closed body, wound outward, is convex.
bool isConvex(const ConvexShape& shape) {
  if (shape.vertices.size() > kMaxPartVertices) return false;
  const double extent = extentOf(shape);
  if (signedVolume({shape.vertices, shape.triangles}) < kFlat * extent * extent * extent) {
    return false;
  }
  return worstBulge(shape) <= kConvexTolerance * std::max(1.0, extent);
}

/// Goes through an imported mesh, node by node.
class PartCollector {
 public:
  PartCollector(const fs::path& file, const ImportedMesh& mesh, const Eigen::Vector3d& scale,
                const ConvexDecomposer& divide)
      : file_(file), mesh_(mesh), scale_(scale), divide_(divide) {}

  BodyShapes collect() {
    for (const MeshNode& node : mesh_.nodes) addBodies(node);
    if (out_.shapes.empty() && faults_.empty()) refuse(file_, "holds no triangles");
    if (!faults_.empty()) throw FileError(std::move(faults_));
    return std::move(out_);
  }

 private:
  /// A file's materials cut a node into pieces; its bodies don't care.
  void addBodies(const MeshNode& node) {
    PlaceMerger places;
    std::vector<TriangleMesh> pieces;
    for (const std::uint32_t index : node.pieces) {
      const MeshPiece& piece = mesh_.pieces[index];
      if ((triangles_ += piece.triangles.size()) > kMaxMeshTriangles) {
        refuse(file_, "has more than " + std::to_string(kMaxMeshTriangles) + " triangles");
      }
      pieces.push_back(placedPiece(piece, node.transform, places));
    }
    for (SurfaceBody& body : bodiesOf(pieces)) addBody(node.name, std::move(body));
  }

  void addBody(const std::string& name, SurfaceBody body) {
    if (out_.shapes.size() + faults_.size() >= kMaxMeshParts) {
      refuse(file_, "has more than " + std::to_string(kMaxMeshParts) + " parts");
    }
    if (body.open_edges == 0) {
      ConvexShape whole{body.mesh.vertices, body.mesh.triangles};
      if (isConvex(whole)) return out_.shapes.push_back({Pose::Identity(), std::move(whole)});
    }
    auto parts = divide_(body.mesh);
    if (!parts) {
      faults_.push_back({file_.string(), 0, "part '" + name + "' " + parts.error().detail});
      return;
    }
    const std::uint64_t hash = partsHash(body.mesh);
    out_.divided.push_back({std::move(body.mesh), body.open_edges, hash,
                            static_cast<int>(out_.shapes.size()), static_cast<int>(parts->size())});
    for (TriangleMesh& part : *parts) {
      out_.shapes.push_back(
          {Pose::Identity(), ConvexShape{std::move(part.vertices), std::move(part.triangles)}});
    }
  }

  TriangleMesh placedPiece(const MeshPiece& piece, const Eigen::Matrix4d& transform,
                           PlaceMerger& places) const {
    TriangleMesh out;
    for (const auto& triangle : piece.triangles) {
      const int first = static_cast<int>(out.vertices.size());
      for (const std::uint32_t index : triangle) {
        out.vertices.push_back(places.placeOf(placed(piece.vertices[index], transform)));
      }
      out.triangles.push_back({first, first + 1, first + 2});
    }
    return out;
  }

  Eigen::Vector3d placed(const std::array<float, 3>& v, const Eigen::Matrix4d& transform) const {
    const Eigen::Vector4d p = transform * Eigen::Vector4d(v[0], v[1], v[2], 1.0);
    Eigen::Vector3d at = p.head<3>().cwiseProduct(scale_);
    // Beyond a kilometre the merging grid would overflow, and it is no part of a robot's cell.
    if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1000.0) {
      refuse(file_, "has a vertex that is not finite or beyond 1 km (metres expected)");
    }
    return at;
  }

  const fs::path& file_;
  const ImportedMesh& mesh_;
  Eigen::Vector3d scale_;
  std::size_t triangles_ = 0;
  const ConvexDecomposer& divide_;
  BodyShapes out_;
  std::vector<FileFault> faults_;
};

MeshFormat formatOf(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (extension == ".stl") return MeshFormat::kStl;
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".dae") return MeshFormat::kDae;
  refuse(file, "is not STL, OBJ or DAE");
}

}  // namespace

BodyShapes readMeshBodies(const fs::path& file, const Eigen::Vector3d& scale,
                          const ConvexDecomposer& divide) {
  MeshImporter importer;
  return readMeshBodies(file, scale, divide, importer);
}

BodyShapes readMeshBodies(const fs::path& file, const Eigen::Vector3d& scale,
                          const ConvexDecomposer& divide, MeshImporter& importer) {
  const MeshFormat format = formatOf(file);
  const Result<std::string> text = readFileText(file, kMaxMib);
  if (!text) refuse(file, text.error().detail);
  if (auto faults = meshFaults(file, format, *text); !faults.empty()) {
    throw FileError(std::move(faults));
  }
  const Result<ImportedMesh> mesh = importer.read(file, *text);
  if (!mesh) {
    const std::string& detail = mesh.error().detail;
    refuse(file, "cannot be read as a mesh" + (detail.empty() ? "" : ": " + detail));
  }
  return PartCollector(file, *mesh, scale, divide).collect();
}

std::vector<Shape> readConvexMesh(const fs::path& file, const Eigen::Vector3d& scale,
                                  const ConvexDecomposer& divide) {
  return readMeshBodies(file, scale, divide).shapes;
}

std::string MeshTotal::add(const fs::path& file) {
  std::error_code ignored;
  if (const std::uintmax_t bytes = fs::file_size(file, ignored); !ignored) bytes_ += bytes;
  if (bytes_ >> 20 <= kMaxTotalMib) return {};
  return "the meshes up to here have more than " + std::to_string(kMaxTotalMib) + " MiB";
}

}  // namespace handover
