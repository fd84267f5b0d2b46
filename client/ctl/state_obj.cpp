// SPDX-License-Identifier: Apache-2.0
#include "state_obj.hpp"

#include "view/mesh_file.hpp"
#include "view/playback.hpp"
#include "view/root_files.hpp"

#include <handover/client/plan_file.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

namespace handover::ctl {
namespace {

namespace fs = std::filesystem;
using client::PlanFileError;

constexpr int kSides = 32;  // of a cylinder; a sphere has half as many rings

/// Corners of triangles, three each.
using Triangles = std::vector<Eigen::Vector3d>;

void quad(Triangles& out, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
          const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  out.insert(out.end(), {a, b, c, a, c, d});
}

Triangles trianglesOf(const BoxGeometry& box) {
  const Eigen::Vector3d half(0.5 * box.size[0], 0.5 * box.size[1], 0.5 * box.size[2]);
  Triangles out;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto corner = [&](double u, double v) {
        Eigen::Vector3d p;
        p[axis] = side * half[axis];
        p[(axis + 1) % 3] = side * u * half[(axis + 1) % 3];
        p[(axis + 2) % 3] = v * half[(axis + 2) % 3];
        return p;
      };
      quad(out, corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1));
    }
  }
  return out;
}

/// A surface of revolution about z. @param profile radius and height, from below.
Triangles turned(const std::vector<std::array<double, 2>>& profile) {
  const auto at = [&](std::size_t ring, int side) {
    const double angle = 2 * std::numbers::pi * side / kSides;
    const auto& [r, z] = profile[ring];
    return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z);
  };
  Triangles out;
  for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (int side = 0; side < kSides; ++side) {
      quad(out, at(ring, side), at(ring, side + 1), at(ring + 1, side + 1), at(ring + 1, side));
    }
  }
  return out;
}

Triangles trianglesOf(const SphereGeometry& sphere) {
  std::vector<std::array<double, 2>> profile;
  for (int ring = 0; ring <= kSides / 2; ++ring) {
    const double angle = std::numbers::pi * (2.0 * ring / kSides - 0.5);
    profile.push_back({sphere.radius * std::cos(angle), sphere.radius * std::sin(angle)});
  }
  return turned(profile);
}

Triangles trianglesOf(const CylinderGeometry& cylinder) {
  const double r = cylinder.radius, h = 0.5 * cylinder.length;
  return turned({{0, -h}, {r, -h}, {r, h}, {0, h}});
}

/// Appends bodies to the text; corners count through the whole file, from 1.
class ObjWriter {
 public:
  explicit ObjWriter(const view::RootFiles& files) : files_(files) {}

  void begin(const std::string& body) { text_ += "o " + body + "\n"; }

  /// @param urdf that names the geometry's mesh; empty: the path is of the root.
  void add(const Geometry& geometry, const Pose& X_WS, const std::string& urdf) {
    if (const auto* compound = std::get_if<CompoundGeometry>(&geometry)) {
      for (const GeometryPart& part : compound->parts) {
        add(part.geometry, X_WS * toPose(part.X_OS), urdf);
      }
    } else if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
      add(trianglesOf(*box), X_WS);
    } else if (const auto* sphere = std::get_if<SphereGeometry>(&geometry)) {
      add(trianglesOf(*sphere), X_WS);
    } else if (const auto* cylinder = std::get_if<CylinderGeometry>(&geometry)) {
      add(trianglesOf(*cylinder), X_WS);
    } else if (const auto* mesh = std::get_if<MeshGeometry>(&geometry)) {
      Triangles corners = view::meshTriangles(fileOf(mesh->path, urdf));
      for (Eigen::Vector3d& p : corners) {
        for (int axis = 0; axis < 3; ++axis) p[axis] *= mesh->scale[static_cast<std::size_t>(axis)];
      }
      add(corners, X_WS);
    }
  }

  std::string text() && { return std::move(text_); }

 private:
  fs::path fileOf(const std::string& path, const std::string& urdf) const {
    if (urdf.empty()) return files_.pathOf(path);
    const auto found = files_.findMesh(path, urdf);
    if (!found) throw PlanFileError(urdf, "mesh \"" + path + "\" not found");
    return files_.pathOf(*found);
  }

  void add(const Triangles& corners, const Pose& X_WS) {
    char line[96];
    for (const Eigen::Vector3d& corner : corners) {
      const Eigen::Vector3d p = X_WS * corner;
      std::snprintf(line, sizeof line, "v %.6f %.6f %.6f\n", p.x(), p.y(), p.z());
      text_ += line;
    }
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      const std::size_t first = next_ + i;
      text_ += "f " + std::to_string(first) + " " + std::to_string(first + 1) + " " +
               std::to_string(first + 2) + "\n";
    }
    next_ += corners.size();
  }

  const view::RootFiles& files_;
  std::string text_;
  std::size_t next_ = 1;
};

double timeOf(const std::string& kind, const view::Playback& playback) {
  if (kind == "start") return 0;
  if (kind == "end") return playback.duration();
  for (const StageTrajectory& stage : playback.plan().stages) {
    const std::string name = toString(stage.action) + ("." + std::to_string(stage.holder));
    if (kind == name || kind == std::to_string(stage.index)) return stage.start + stage.t.back();
  }
  throw PlanFileError("/plan/stages", "no stage '" + kind + "'");
}

}  // namespace

bool namesState(const std::string& kind) {
  if (kind == "start" || kind == "end") return true;
  const auto dot = kind.find('.');
  const std::string number = dot == std::string::npos ? kind : kind.substr(dot + 1);
  if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) return false;
  return dot == std::string::npos || fromString<StageAction>(kind.substr(0, dot)).has_value();
}

std::string stateObj(std::string_view plan_text, const fs::path& root, const std::string& kind) {
  const view::RootFiles files(root);
  const view::Playback playback(client::parsePlanFile(plan_text), files);
  const SceneSnapshot& scene = playback.scene();
  const view::Moment moment = playback.at(timeOf(kind, playback));
  ObjWriter writer(files);
  for (std::size_t robot = 0; robot < scene.robots.size(); ++robot) {
    const auto& links = playback.models()[robot].links();
    for (std::size_t link = 0; link < links.size(); ++link) {
      if (links[link].collision.empty()) continue;
      writer.begin(scene.robots[robot].name + "/" + links[link].name);
      for (const view::Shape& shape : links[link].collision) {
        writer.add(shape.geometry, moment.X_WL[robot][link] * shape.X_LS, scene.robots[robot].urdf);
      }
    }
  }
  for (std::size_t object = 0; object < scene.objects.size(); ++object) {
    writer.begin(scene.objects[object].name);
    writer.add(scene.objects[object].geometry, moment.X_WO[object], "");
  }
  return std::move(writer).text();
}

}  // namespace handover::ctl
