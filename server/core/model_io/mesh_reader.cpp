// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/mesh_reader.hpp"

#include "core/decomposition/decomposition_file.hpp"
#include "core/decomposition/surface_bodies.hpp"
#include "core/model_io/file_fault.hpp"
#include "core/model_io/file_text.hpp"
#include "core/model_io/mesh_checker.hpp"

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
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

Eigen::Matrix4d matrixOf(const aiMatrix4x4& m) {
  Eigen::Matrix4d out;
  out << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3,
      m.d4;
  return out;
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

/// Walks an imported scene, node by node.
class PartCollector {
 public:
  PartCollector(const fs::path& file, const aiScene& scene, const Eigen::Vector3d& scale,
                const ConvexDecomposer& divide)
      : file_(file), scene_(scene), scale_(scale), divide_(divide) {}

  BodyShapes collect() {
    visit(*scene_.mRootNode, Eigen::Matrix4d::Identity());
    if (out_.shapes.empty() && faults_.empty()) refuse(file_, "holds no triangles");
    if (!faults_.empty()) throw FileError(std::move(faults_));
    return std::move(out_);
  }

 private:
  void visit(const aiNode& node, const Eigen::Matrix4d& above) {
    const Eigen::Matrix4d transform = above * matrixOf(node.mTransformation);
    addBodies(node, transform);
    for (unsigned i = 0; i < node.mNumChildren; ++i) visit(*node.mChildren[i], transform);
  }

  /// A file's materials cut a node into meshes; its bodies don't care.
  void addBodies(const aiNode& node, const Eigen::Matrix4d& transform) {
    PlaceMerger places;
    std::vector<TriangleMesh> pieces;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_.mNumMeshes) refuse(file_, "is damaged");
      const aiMesh& mesh = *scene_.mMeshes[node.mMeshes[i]];
      if ((triangles_ += mesh.mNumFaces) > kMaxMeshTriangles) {
        refuse(file_, "has more than " + std::to_string(kMaxMeshTriangles) + " triangles");
      }
      pieces.push_back(placedPiece(mesh, transform, places));
    }
    for (SurfaceBody& body : bodiesOf(pieces)) addBody(nameOf(node), std::move(body));
  }

  std::string nameOf(const aiNode& node) const {
    const aiString& of_mesh = scene_.mMeshes[node.mMeshes[0]]->mName;
    return of_mesh.length > 0 ? of_mesh.C_Str() : node.mName.C_Str();
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

  TriangleMesh placedPiece(const aiMesh& mesh, const Eigen::Matrix4d& transform,
                           PlaceMerger& places) const {
    TriangleMesh piece;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      const int first = static_cast<int>(piece.vertices.size());
      for (unsigned i = 0; i < 3; ++i) {
        if (face.mIndices[i] >= mesh.mNumVertices) refuse(file_, "is damaged");
        piece.vertices.push_back(
            places.placeOf(placed(mesh.mVertices[face.mIndices[i]], transform)));
      }
      piece.triangles.push_back({first, first + 1, first + 2});
    }
    return piece;
  }

  Eigen::Vector3d placed(const aiVector3D& v, const Eigen::Matrix4d& transform) const {
    const Eigen::Vector4d p = transform * Eigen::Vector4d(v.x, v.y, v.z, 1.0);
    Eigen::Vector3d at = p.head<3>().cwiseProduct(scale_);
    // Beyond a kilometre the merging grid would overflow, and it is no part of a robot's cell.
    if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1000.0) {
      refuse(file_, "has a vertex that is not finite or beyond 1 km (metres expected)");
    }
    return at;
  }

  const fs::path& file_;
  const aiScene& scene_;
  Eigen::Vector3d scale_;
  std::size_t triangles_ = 0;
  const ConvexDecomposer& divide_;
  BodyShapes out_;
  std::vector<FileFault> faults_;
};

/// A file's text for assimp to read.
class TextStream : public Assimp::IOStream {
 public:
  explicit TextStream(const std::string& text) : text_(text) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    const std::size_t whole = size == 0 ? 0 : std::min(count, (text_.size() - at_) / size);
    std::memcpy(to, text_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }

  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }

  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t from = origin == aiOrigin_SET   ? 0
                             : origin == aiOrigin_CUR ? at_
                                                      : text_.size();
    if (offset > text_.size() - from) return aiReturn_FAILURE;
    at_ = from + offset;
    return aiReturn_SUCCESS;
  }

  std::size_t Tell() const override { return at_; }

  std::size_t FileSize() const override { return text_.size(); }

  void Flush() override {}

 private:
  const std::string& text_;
  std::size_t at_ = 0;
};

/// The one file that was asked for: materials and textures that it names are not wanted, and may be
/// pipes.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::string& text) : name_(std::move(name)), text_(text) {}

  bool Exists(const char* name) const override { return name == name_; }

  char getOsSeparator() const override { return '/'; }

  Assimp::IOStream* Open(const char* name, const char*) override {
    return Exists(name) ? new TextStream(text_) : nullptr;
  }

  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string name_;
  const std::string& text_;
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
  const MeshFormat format = formatOf(file);
  const Result<std::string> text = readFileText(file, kMaxMib);
  if (!text) refuse(file, text.error().detail);
  if (auto faults = meshFaults(file, format, *text); !faults.empty()) {
    throw FileError(std::move(faults));
  }
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(file.string(), *text));  // the importer's from here on
  // URDF takes a Collada file's axes as written; assimp would turn them to y up. The unit is
  // honoured by assimp itself, in the root node's transform.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    const std::string detail = importer.GetErrorString();
    refuse(file, "cannot be read as a mesh" + (detail.empty() ? "" : ": " + detail));
  }
  return PartCollector(file, *scene, scale, divide).collect();
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
