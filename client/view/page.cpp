// SPDX-License-Identifier: Apache-2.0
#include "view/page.hpp"

#include "view/page_templates.hpp"
#include "view/root_files.hpp"

#include <handover/client/plan_file.hpp>

#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace handover::view {
namespace {

namespace fs = std::filesystem;
using client::PlanFileError;
using Json = nlohmann::json;

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

std::string kindOf(const std::string& path) {
  std::string kind = fs::path(path).extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return kind;
}

bool isDrawn(const std::string& path) {
  const std::string kind = kindOf(path);
  return kind == ".obj" || kind == ".stl" || kind == ".dae";
}

/// Files need not be UTF-8: what is not becomes U+FFFD.
std::string textOf(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// What the page needs of files: their content by path, and the mesh names of each URDF.
class PageFiles {
 public:
  explicit PageFiles(const fs::path& root) : root_(root) {}

  /// All that a plan file's scene names.
  void addScene(const std::string& plan_text) {
    const client::PlanFile file = client::parsePlanFile(plan_text);
    if (!file.scene) throw PlanFileError("/scene", "is null: there is nothing to show");
    for (const RobotSnapshot& robot : file.scene->robots) addRobot(robot.urdf);
    for (const ObjectSnapshot& object : file.scene->objects) addGeometry(object.geometry);
  }

  /// The page's data up to what is shown, as JSON text that is still open.
  std::string openJson() const {
    return "{\"files\":" + textOf(files_) + ",\"meshes\":" + textOf(meshes_);
  }

 private:
  void addRobot(const std::string& urdf) {
    if (meshes_.contains(urdf)) return;
    add(urdf);
    tinyxml2::XMLDocument document;
    const std::string text = files_[urdf]["text"];
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
      throw PlanFileError(urdf, document.ErrorStr());
    }
    meshes_[urdf] = Json::object();
    if (document.RootElement() != nullptr) addMeshes(*document.RootElement(), urdf);
  }

  void addGeometry(const Geometry& geometry) {
    if (const auto* mesh = std::get_if<MeshGeometry>(&geometry)) {
      add(mesh->path);
    } else if (const auto* compound = std::get_if<CompoundGeometry>(&geometry)) {
      for (const auto& part : compound->parts) addGeometry(part.geometry);
    }
  }

  void add(const std::string& path) {
    if (files_.contains(path)) return;
    const std::string content = root_.read(path);
    files_[path] =
        kindOf(path) == ".stl" ? Json{{"base64", base64(content)}} : Json{{"text", content}};
  }

  /// A picture that is not there, or of a kind that the page cannot draw, is left out: the page
  /// shows the link's collision shapes instead.
  void addMesh(const std::string& name, const std::string& urdf, bool picture) {
    const std::optional<std::string> path = root_.findMesh(name, urdf);
    if (path && isDrawn(*path)) {
      add(*path);
      meshes_[urdf][name] = *path;
    } else if (!picture) {
      throw PlanFileError(urdf,
                          "mesh \"" + name + "\" " + (path ? "cannot be drawn" : "not found"));
    }
  }

  void addMeshes(const tinyxml2::XMLElement& element, const std::string& urdf,
                 bool picture = false) {
    const std::string_view tag = element.Name();
    const char* name = element.Attribute("filename");
    if (tag == "mesh" && name != nullptr) addMesh(name, urdf, picture);
    for (auto* child = element.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      addMeshes(*child, urdf, picture || tag == "visual");
    }
  }

  const RootFiles root_;
  Json files_ = Json::object();
  Json meshes_ = Json::object();
};

/// JSON that may stand inside a script element.
std::string embeddable(const std::string& json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

PageTemplates templates() {
  const auto found = pageTemplates();
  if (!found) throw std::logic_error(kNoPages);
  return *found;
}

std::string filled(std::string_view page, const std::string& json) {
  const std::string_view marker = "@DATA@";
  const std::size_t at = page.rfind(marker);
  return std::string(page.substr(0, at)) + embeddable(json) +
         std::string(page.substr(at + marker.size()));
}

}  // namespace

bool hasPages() { return pageTemplates().has_value(); }

std::string planPage(const std::string& plan_text, const fs::path& root) {
  PageFiles files(root);
  files.addScene(plan_text);
  return filled(templates().plan, files.openJson() + ",\"file\":" + plan_text + "}");
}

std::string failuresPage(const std::vector<NamedPlan>& failures, const fs::path& root) {
  PageFiles files(root);
  std::string runs;
  for (const auto& [name, text] : failures) {
    files.addScene(text);
    runs += (runs.empty() ? "" : ",") + ("{\"name\":\"" + name + "\",\"file\":" + text + "}");
  }
  return filled(templates().plan, files.openJson() + ",\"runs\":[" + runs + "]}");
}

std::string experimentPage(const std::string& data) { return filled(templates().experiment, data); }

}  // namespace handover::view
