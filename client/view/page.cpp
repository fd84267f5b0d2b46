// SPDX-License-Identifier: Apache-2.0
#include "view/page.hpp"

#include "verify/input_file.hpp"
#include "verify/plan_file.hpp"
#include "verify/unreadable.hpp"
#include "view/page_templates.hpp"

#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <tinyxml2.h>

#include <stdexcept>
#include <string_view>

namespace handover::view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using verify::Unreadable;

constexpr std::uint64_t kMaxFileBytes = 64u << 20;

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

/// What the page needs of files: their content by path, and the mesh names of each URDF.
class PageFiles {
 public:
  explicit PageFiles(const fs::path& root) : root_(root) {}

  void addRobot(const std::string& urdf) {
    add(urdf, root_ / urdf);
    tinyxml2::XMLDocument document;
    const std::string text = files_[urdf]["text"];
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
      throw Unreadable(urdf, document.ErrorStr());
    }
    meshes_[urdf] = Json::object();
    if (document.RootElement() != nullptr) addMeshes(*document.RootElement(), urdf);
  }

  void addGeometry(const verify::Geometry& geometry) {
    if (const auto* mesh = std::get_if<verify::MeshFile>(&geometry)) {
      add(mesh->path, root_ / mesh->path);
    } else if (const auto* compound = std::get_if<verify::Compound>(&geometry)) {
      for (const auto& part : compound->parts) addGeometry(part.geometry);
    }
  }

  Json files() { return std::move(files_); }

  Json meshes() { return std::move(meshes_); }

 private:
  void add(const std::string& key, const fs::path& file) {
    if (files_.contains(key)) return;
    const std::string content = verify::readFile(file, kMaxFileBytes);
    const bool binary = file.extension() == ".stl" || file.extension() == ".STL";
    files_[key] = binary ? Json{{"base64", base64(content)}} : Json{{"text", content}};
  }

  void addMeshes(const tinyxml2::XMLElement& element, const std::string& urdf) {
    const char* name = element.Attribute("filename");
    if (std::string_view(element.Name()) == "mesh" && name != nullptr) {
      const fs::path file = verify::resolveUrdfMesh(name, root_ / urdf, root_);
      const std::string key = file.lexically_normal().lexically_relative(root_).string();
      add(key, file);
      meshes_[urdf][name] = key;
    }
    for (auto* child = element.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      addMeshes(*child, urdf);
    }
  }

  const fs::path root_;
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
  const verify::Plan plan = verify::parsePlan(plan_text);
  PageFiles files(root);
  for (const auto& robot : plan.robots) files.addRobot(robot.urdf);
  for (const auto& object : plan.objects) files.addGeometry(object.geometry);

  return filled(templates().plan, "{\"files\":" + files.files().dump() + ",\"meshes\":" +
                                      files.meshes().dump() + ",\"plan\":" + plan_text + "}");
}

std::string experimentPage(const std::string& data) { return filled(templates().experiment, data); }

}  // namespace handover::view
