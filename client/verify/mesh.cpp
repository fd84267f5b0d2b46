// SPDX-License-Identifier: Apache-2.0
#include "verify/mesh.hpp"

#include "verify/unreadable.hpp"

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <string>

namespace handover::verify {
namespace {

constexpr std::size_t kMaxTriangles = 2'000'000;
constexpr std::size_t kLongestReason = 200;  // some quote the whole file
constexpr double kWeld = 1e-7;               // [m]: vertices nearer than about this are one

Eigen::Matrix4d toEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  result << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return result;
}

/// The meshes of each node, placed.
void collect(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& X_above,
             std::vector<std::vector<Mesh>>& nodes) {
  const Eigen::Matrix4d X = X_above * toEigen(node.mTransformation);
  std::vector<Mesh> meshes;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[m]];
    Mesh& mesh = meshes.emplace_back();
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D& p = part.mVertices[v];
      mesh.vertices.push_back((X * Eigen::Vector4d(p.x, p.y, p.z, 1)).head<3>());
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines bound nothing
      mesh.triangles.push_back({static_cast<int>(face.mIndices[0]),
                                static_cast<int>(face.mIndices[1]),
                                static_cast<int>(face.mIndices[2])});
    }
  }
  nodes.push_back(std::move(meshes));
  for (unsigned c = 0; c < node.mNumChildren; ++c) collect(scene, *node.mChildren[c], X, nodes);
}

/// Numbers shared by all vertices at (nearly) one place.
std::vector<int> weld(const Mesh& mesh) {
  std::map<std::array<std::int64_t, 3>, int> places;
  std::vector<int> number(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    std::array<std::int64_t, 3> key{};
    for (int k = 0; k < 3; ++k) {
      key[static_cast<std::size_t>(k)] = std::llround(mesh.vertices[i][k] / kWeld);
    }
    number[i] = places.emplace(key, static_cast<int>(places.size())).first->second;
  }
  return number;
}

class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  int find(int a) {
    while (at(a) != a) a = at(a) = at(at(a));
    return a;
  }

  void join(int a, int b) { at(find(a)) = find(b); }

 private:
  int& at(int i) { return parent_[static_cast<std::size_t>(i)]; }

  std::vector<int> parent_;
};

double signedVolume(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto vertex = [&](int k) { return mesh.vertices[static_cast<std::size_t>(k)]; };
    sum += vertex(t[0]).dot(vertex(t[1]).cross(vertex(t[2])));
  }
  return sum / 6;
}

/// Parity of the crossings of a ray with the mesh.
bool oddCrossings(const Mesh& mesh, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  bool odd = false;
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Eigen::Vector3d ab = mesh.vertices[static_cast<std::size_t>(t[1])] - a;
    const Eigen::Vector3d ac = mesh.vertices[static_cast<std::size_t>(t[2])] - a;
    const Eigen::Vector3d normal = ray.cross(ac);
    const double determinant = ab.dot(normal);
    if (determinant == 0) continue;
    const Eigen::Vector3d ao = origin - a;
    const double u = ao.dot(normal) / determinant;
    if (u < 0 || u > 1) continue;
    const Eigen::Vector3d cross = ao.cross(ab);
    const double v = ray.dot(cross) / determinant;
    if (v < 0 || u + v > 1) continue;
    if (ac.dot(cross) / determinant > 0) odd = !odd;
  }
  return odd;
}

/// A text STL as whoever wrote it: every three "vertex x y z" are a triangle. For dialects that
/// assimp refuses, as one with an empty solid. Empty: it is none.
Mesh readTextStl(const std::filesystem::path& file) {
  Mesh mesh;
  std::ifstream stream(file);
  std::string word;
  if (!(stream >> word) || word != "solid") return mesh;
  while (stream >> word) {
    if (word != "vertex") continue;
    Eigen::Vector3d vertex;
    for (int k = 0; k < 3; ++k) {
      if (!(stream >> word)) return {};
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), vertex[k]);
      if (error != std::errc() || end != word.data() + word.size()) return {};
    }
    mesh.vertices.push_back(vertex);
  }
  if (mesh.vertices.size() % 3 != 0 || mesh.vertices.size() / 3 > kMaxTriangles) return {};
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); v += 3) {
    mesh.triangles.push_back({v, v + 1, v + 2});
  }
  return mesh;
}

bool isStl(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".stl";
}

/// A node's meshes are one body cut by its materials, but for those that are closed by themselves.
void joinOpenOnes(std::vector<Mesh> node, std::vector<Mesh>& meshes) {
  Mesh joined;
  for (Mesh& mesh : node) {
    const std::vector<Shell> shells = node.size() > 1 ? shellsOf(mesh) : std::vector<Shell>();
    const bool closed =
        std::all_of(shells.begin(), shells.end(), [](const Shell& shell) { return shell.closed; });
    if (closed) {
      meshes.push_back(std::move(mesh));
    } else {
      joined.append(mesh);
    }
  }
  if (!joined.triangles.empty()) meshes.push_back(std::move(joined));
}

}  // namespace

void Mesh::append(const Mesh& other) {
  const int base = static_cast<int>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles) {
    triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
}

void Mesh::transform(const Pose& X) {
  for (Eigen::Vector3d& vertex : vertices) vertex = X * vertex;
}

std::vector<Mesh> readMesh(const std::filesystem::path& file, const Eigen::Vector3d& scale) {
  Assimp::Importer importer;
  // A robot's frames are those of the file: no turning to y-up.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType);
  std::vector<std::vector<Mesh>> nodes;
  if (scene && scene->mRootNode) {
    collect(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), nodes);
  } else {
    if (isStl(file)) nodes.push_back({readTextStl(file)});
    if (nodes.empty() || nodes.front().front().triangles.empty()) {
      throw Unreadable(file.string(),
                       std::string(importer.GetErrorString()).substr(0, kLongestReason));
    }
  }
  std::size_t triangles = 0;
  std::vector<Mesh> meshes;
  for (std::vector<Mesh>& node : nodes) {
    for (Mesh& mesh : node) {
      triangles += mesh.triangles.size();
      for (Eigen::Vector3d& vertex : mesh.vertices) {
        vertex = vertex.cwiseProduct(scale);
        if (!vertex.allFinite()) throw Unreadable(file.string(), "vertex not finite");
      }
    }
    joinOpenOnes(std::move(node), meshes);
  }
  if (triangles == 0) throw Unreadable(file.string(), "no triangle in it");
  if (triangles > kMaxTriangles) throw Unreadable(file.string(), "too many triangles");
  return meshes;
}

Mesh boxMesh(const Eigen::Vector3d& size) {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices.push_back(size.cwiseProduct(Eigen::Vector3d(
        corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5)));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Mesh cylinderMesh(double radius, double length) {
  constexpr int kSides = 90;
  const double outer = radius / std::cos(std::numbers::pi / kSides);
  Mesh mesh;
  for (const double z : {-length / 2, length / 2}) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      mesh.vertices.emplace_back(outer * std::cos(angle), outer * std::sin(angle), z);
    }
  }
  mesh.vertices.emplace_back(0, 0, -length / 2);
  mesh.vertices.emplace_back(0, 0, length / 2);
  for (int i = 0; i < kSides; ++i) {
    const int next = (i + 1) % kSides;
    mesh.triangles.push_back({i, next, kSides + next});
    mesh.triangles.push_back({i, kSides + next, kSides + i});
    mesh.triangles.push_back({2 * kSides, next, i});
    mesh.triangles.push_back({2 * kSides + 1, kSides + i, kSides + next});
  }
  return mesh;
}

Mesh sphereMesh(double radius) {
  constexpr int kRings = 48, kSides = 96;
  Mesh mesh;
  mesh.vertices.emplace_back(0, 0, 1);
  for (int ring = 1; ring < kRings; ++ring) {
    const double polar = std::numbers::pi * ring / kRings;
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      mesh.vertices.emplace_back(std::sin(polar) * std::cos(angle),
                                 std::sin(polar) * std::sin(angle), std::cos(polar));
    }
  }
  mesh.vertices.emplace_back(0, 0, -1);
  const int south = static_cast<int>(mesh.vertices.size()) - 1;
  const auto at = [](int ring, int i) { return 1 + (ring - 1) * kSides + i % kSides; };
  for (int i = 0; i < kSides; ++i) {
    mesh.triangles.push_back({0, at(1, i), at(1, i + 1)});
    mesh.triangles.push_back({south, at(kRings - 1, i + 1), at(kRings - 1, i)});
    for (int ring = 1; ring + 1 < kRings; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)});
    }
  }
  double nearest = 1;
  for (const Triangle& t : mesh.triangles) {
    const auto vertex = [&](int k) { return mesh.vertices[static_cast<std::size_t>(k)]; };
    nearest = std::min(nearest, nearestOnTriangle(Eigen::Vector3d::Zero(), vertex(t[0]),
                                                  vertex(t[1]), vertex(t[2]))
                                    .norm());
  }
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= radius / nearest;
  return mesh;
}

bool Shell::contains(const Eigen::Vector3d& point) const {
  if (!closed || !box.contains(point)) return false;
  // Three odd directions vote: a ray through an edge may miscount, two of them hardly will.
  int inside = 0;
  inside += oddCrossings(mesh, point, Eigen::Vector3d(0.5377, 0.7339, 0.4156));
  inside += oddCrossings(mesh, point, Eigen::Vector3d(-0.2588, 0.3188, 0.9118));
  inside += oddCrossings(mesh, point, Eigen::Vector3d(0.8622, -0.4336, -0.2620));
  return inside >= 2;
}

double Shell::depth(const Eigen::Vector3d& point) const {
  if (round) {
    const Eigen::Vector3d p_S = round->X_BS.inverse() * point;
    if (round->length == 0) return std::max(0.0, round->radius - p_S.norm());
    return std::max(
        0.0, std::min(round->radius - p_S.head<2>().norm(), round->length / 2 - std::abs(p_S.z())));
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles) {
    const auto vertex = [&](int k) { return mesh.vertices[static_cast<std::size_t>(k)]; };
    nearest = std::min(
        nearest,
        (point - nearestOnTriangle(point, vertex(t[0]), vertex(t[1]), vertex(t[2]))).squaredNorm());
  }
  return std::sqrt(nearest);
}

Eigen::Vector3d Shell::onSurface(const Eigen::Vector3d& point) const {
  if (!round) return point;
  Eigen::Vector3d p_S = round->X_BS.inverse() * point;
  if (round->length == 0) {
    p_S *= round->radius / p_S.norm();
  } else if (const double r = p_S.head<2>().norm(); r > round->radius) {
    p_S.head<2>() *= round->radius / r;
  }
  return round->X_BS * p_S;
}

Eigen::Vector3d Shell::normalAt(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  if (!round) return normal;
  Eigen::Vector3d p_S = round->X_BS.inverse() * point;
  if (round->length > 0) {
    const bool cap = std::abs((round->X_BS.linear().transpose() * normal).z()) > 0.5;
    if (cap) return normal;
    p_S.z() = 0;
  }
  return round->X_BS.linear() * p_S.normalized();
}

std::vector<Shell> shellsOf(const Mesh& mesh) {
  const std::vector<int> number = weld(mesh);
  const int places = number.empty() ? 0 : *std::max_element(number.begin(), number.end()) + 1;
  const auto place = [&](int vertex) { return number[static_cast<std::size_t>(vertex)]; };
  UnionFind pieces(static_cast<std::size_t>(places));
  for (const Triangle& t : mesh.triangles) {
    pieces.join(place(t[0]), place(t[1]));
    pieces.join(place(t[1]), place(t[2]));
  }
  std::map<int, std::size_t> shell_of_piece;
  std::vector<Shell> shells;
  std::vector<int> index(static_cast<std::size_t>(places), -1);
  std::vector<std::map<std::pair<int, int>, int>> edges;
  for (const Triangle& t : mesh.triangles) {
    const std::array<int, 3> at = {place(t[0]), place(t[1]), place(t[2])};
    if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0]) continue;  // no area
    const auto [entry, is_new] = shell_of_piece.emplace(pieces.find(at[0]), shells.size());
    if (is_new) {
      shells.emplace_back();
      edges.emplace_back();
    }
    Shell& shell = shells[entry->second];
    Triangle local{};
    for (std::size_t k = 0; k < 3; ++k) {
      int& slot = index[static_cast<std::size_t>(at[k])];
      if (slot < 0) {
        slot = static_cast<int>(shell.mesh.vertices.size());
        shell.mesh.vertices.push_back(mesh.vertices[static_cast<std::size_t>(t[k])]);
        shell.box.extend(shell.mesh.vertices.back());
      }
      local[k] = slot;
      const std::size_t next = (k + 1) % 3;
      ++edges[entry->second][std::minmax(at[k], at[next])];
    }
    shell.mesh.triangles.push_back(local);
  }
  for (std::size_t s = 0; s < shells.size(); ++s) {
    shells[s].closed = std::all_of(edges[s].begin(), edges[s].end(),
                                   [](const auto& edge) { return edge.second == 2; });
    if (signedVolume(shells[s].mesh) < 0) {
      for (Triangle& t : shells[s].mesh.triangles) std::swap(t[1], t[2]);
    }
  }
  return shells;
}

Eigen::Vector3d nearestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                  const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  // Ericson, Real-Time Collision Detection §5.1.5: by Voronoi regions.
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  const double scale = 1 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

}  // namespace handover::verify
