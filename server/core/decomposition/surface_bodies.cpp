// SPDX-License-Identifier: Apache-2.0
#include "core/decomposition/surface_bodies.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace handover {
namespace {

using Eigen::Vector3d;
using Corners = std::array<int, 3>;

constexpr double kMeet = 1e-4;  // boxes of open pieces as near as this meet [m]
/// A soup of more pieces than this is one body: nobody meant so many.
constexpr std::size_t kMostOpen = 1000;
/// The same of bodies: as many as convex parts are made of one.
constexpr std::size_t kMostBodies = 512;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

class Groups {
 public:
  explicit Groups(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  std::size_t of(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void join(std::size_t a, std::size_t b) {
    a = of(a), b = of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;  // the first of a group is its root
};

/// An edge as a triangle has it: which one, and whether it runs from the lower vertex to the upper.
struct EdgeUse {
  std::pair<int, int> edge;
  std::size_t triangle;
  bool upward;
};

/// Every use of every edge, those of one edge side by side.
std::vector<EdgeUse> edgesOf(const std::vector<Corners>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      uses.push_back({std::minmax(a, b), t, a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle);
  });
  return uses;
}

/// Calls visit(first, count) for every edge.
template <typename Visit>
void forEachEdge(const std::vector<EdgeUse>& uses, const Visit& visit) {
  for (std::size_t first = 0; first < uses.size();) {
    std::size_t end = first + 1;
    while (end < uses.size() && uses[end].edge == uses[first].edge) ++end;
    visit(&uses[first], end - first);
    first = end;
  }
}

/// The triangles of each group, groups in the order of their first ones.
std::vector<std::vector<Corners>> gathered(const std::vector<Corners>& triangles, Groups& groups) {
  std::map<std::size_t, std::vector<Corners>> by_root;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    by_root[groups.of(t)].push_back(triangles[t]);
  }
  std::vector<std::vector<Corners>> pieces;
  for (auto& [root, piece] : by_root) pieces.push_back(std::move(piece));
  return pieces;
}

/// What hangs together by edges of two triangles: solids that share an edge stay apart.
std::vector<std::vector<Corners>> connected(const std::vector<Corners>& triangles) {
  Groups groups(triangles.size());
  forEachEdge(edgesOf(triangles), [&](const EdgeUse* uses, std::size_t count) {
    if (count == 2) groups.join(uses[0].triangle, uses[1].triangle);
  });
  return gathered(triangles, groups);
}

int openEdges(const std::vector<Corners>& triangles) {
  int open = 0;
  forEachEdge(edgesOf(triangles),
              [&](const EdgeUse*, std::size_t count) { open += count == 2 ? 0 : 1; });
  return open;
}

/// Winds neighbours the same way, from the first triangle of each group on.
void windAlike(std::vector<Corners>& triangles) {
  struct Neighbour {
    std::size_t triangle;
    bool same;  ///< wound the same way as they stand
  };

  std::vector<std::vector<Neighbour>> neighbours(triangles.size());
  forEachEdge(edgesOf(triangles), [&](const EdgeUse* uses, std::size_t count) {
    if (count != 2) return;
    const bool same = uses[0].upward != uses[1].upward;
    neighbours[uses[0].triangle].push_back({uses[1].triangle, same});
    neighbours[uses[1].triangle].push_back({uses[0].triangle, same});
  });
  std::vector<char> state(triangles.size(), 0);  // 0: not seen, 1: as it stands, 2: turned
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (state[start] != 0) continue;
    state[start] = 1;
    for (std::vector<std::size_t> waiting{start}; !waiting.empty();) {
      const std::size_t t = waiting.back();
      waiting.pop_back();
      for (const Neighbour& next : neighbours[t]) {
        if (state[next.triangle] != 0) continue;
        state[next.triangle] = static_cast<char>(next.same ? state[t] : 3 - state[t]);
        waiting.push_back(next.triangle);
      }
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (state[t] == 2) std::swap(triangles[t][1], triangles[t][2]);
  }
}

/// The triangles with the vertices that they use, in the order of their use.
TriangleMesh compact(const std::vector<Vector3d>& vertices, const std::vector<Corners>& triangles) {
  TriangleMesh mesh;
  std::map<int, int> index;
  for (const Corners& t : triangles) {
    Corners& renamed = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [known, fresh] = index.emplace(t[k], static_cast<int>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(vertices[at(t[k])]);
      renamed[k] = known->second;
    }
  }
  return mesh;
}

SurfaceBody bodyOf(const std::vector<Vector3d>& vertices, std::vector<Corners> triangles) {
  SurfaceBody body;
  body.open_edges = openEdges(triangles);
  windAlike(triangles);
  body.mesh = compact(vertices, triangles);
  if (body.open_edges == 0 && signedVolume(body.mesh) < 0) {
    for (Corners& t : body.mesh.triangles) std::swap(t[1], t[2]);
  }
  return body;
}

Eigen::AlignedBox3d boxOf(const std::vector<Vector3d>& vertices,
                          const std::vector<Corners>& triangles) {
  Eigen::AlignedBox3d box;
  for (const Corners& t : triangles) {
    for (const int corner : t) box.extend(vertices[at(corner)]);
  }
  box.min().array() -= kMeet / 2;
  box.max().array() += kMeet / 2;
  return box;
}

/// Open pieces whose boxes meet, as one.
std::vector<std::vector<Corners>> joinedByBoxes(const std::vector<Vector3d>& vertices,
                                                std::vector<std::vector<Corners>> pieces) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const auto& piece : pieces) boxes.push_back(boxOf(vertices, piece));
  Groups groups(pieces.size());
  const bool soup = pieces.size() > kMostOpen;
  for (std::size_t i = 1; i < pieces.size(); ++i) {
    if (soup) groups.join(0, i);
    for (std::size_t j = 0; !soup && j < i; ++j) {
      if (boxes[i].intersects(boxes[j])) groups.join(i, j);
    }
  }
  std::map<std::size_t, std::vector<Corners>> by_root;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    auto& joined = by_root[groups.of(i)];
    joined.insert(joined.end(), pieces[i].begin(), pieces[i].end());
  }
  std::vector<std::vector<Corners>> joined;
  for (auto& [root, piece] : by_root) joined.push_back(std::move(piece));
  return joined;
}

/// The pieces' triangles over one list of vertices, equal places numbered once.
class OneNumbering {
 public:
  std::vector<Corners> add(const TriangleMesh& piece) {
    std::vector<int> number;
    for (const Vector3d& v : piece.vertices) {
      const auto [known, fresh] =
          numbers_.emplace(std::array{v.x(), v.y(), v.z()}, static_cast<int>(vertices.size()));
      if (fresh) vertices.push_back(v);
      number.push_back(known->second);
    }
    std::vector<Corners> triangles;
    for (const Corners& t : piece.triangles) {
      const Corners renamed{number[at(t[0])], number[at(t[1])], number[at(t[2])]};
      if (renamed[0] == renamed[1] || renamed[1] == renamed[2] || renamed[2] == renamed[0])
        continue;
      triangles.push_back(renamed);
    }
    return triangles;
  }

  std::vector<Vector3d> vertices;

 private:
  std::map<std::array<double, 3>, int> numbers_;
};

}  // namespace

std::vector<SurfaceBody> bodiesOf(const std::vector<TriangleMesh>& pieces) {
  OneNumbering all;
  std::vector<SurfaceBody> bodies;
  std::vector<Corners> every, open;
  const auto takeClosed = [&](const std::vector<Corners>& triangles) {
    std::vector<std::vector<Corners>> left;
    for (auto& piece : connected(triangles)) {
      if (openEdges(piece) == 0) {
        bodies.push_back(bodyOf(all.vertices, std::move(piece)));
      } else {
        left.push_back(std::move(piece));
      }
    }
    return left;
  };
  for (const TriangleMesh& piece : pieces) {
    const std::vector<Corners> triangles = all.add(piece);
    every.insert(every.end(), triangles.begin(), triangles.end());
    for (const auto& left : takeClosed(triangles)) {
      open.insert(open.end(), left.begin(), left.end());
    }
  }
  for (auto& body : joinedByBoxes(all.vertices, takeClosed(open))) {
    bodies.push_back(bodyOf(all.vertices, std::move(body)));
  }
  if (bodies.size() > kMostBodies) return {bodyOf(all.vertices, std::move(every))};
  return bodies;
}

double signedVolume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Vector3d origin = mesh.vertices.front();
  double volume = 0;
  for (const Corners& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[at(t[0])] - origin, b = mesh.vertices[at(t[1])] - origin,
                   c = mesh.vertices[at(t[2])] - origin;
    volume += a.dot(b.cross(c));
  }
  return volume / 6;
}

}  // namespace handover
