// SPDX-License-Identifier: Apache-2.0
#include "settings/check.hpp"

#include "core/model_io/file_text.hpp"
#include "core/model_io/mesh_reader.hpp"
#include "core/model_io/srdf_reader.hpp"
#include "core/model_io/urdf_reader.hpp"
#include "settings/cell_file.hpp"
#include "settings/settings_file.hpp"
#include "settings/yaml_reader.hpp"

#include <array>
#include <fstream>

namespace handover {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxMib = 16;  // an URDF's; what a file is tells its own bound

bool isMesh(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension == ".stl" || extension == ".obj" || extension == ".dae";
}

bool isXml(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string::npos && text[first] == '<';
}

bool hasAny(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) {
    if (text.find(word) != std::string::npos) return true;
  }
  return false;
}

bool isSrdf(const fs::path& file, const std::string& text) {
  if (hasAny(text, {"<parent", "<inertial", "<geometry"})) return false;
  return file.extension() == ".srdf" ||
         hasAny(text, {"<group", "<disable_collisions", "<end_effector", "<virtual_joint"});
}

void checkSrdf(const fs::path& file, const fs::path& urdf_file, std::vector<FileFault>& faults) {
  std::error_code error;
  if (!fs::is_regular_file(urdf_file, error)) {
    faults.push_back({file.string(), 0, "its URDF " + urdf_file.string() + " does not exist"});
    return;
  }
  std::vector<FileFault> urdf_faults;
  const UrdfModel urdf = readUrdf(urdf_file, urdf_file.string(), urdf_faults);
  if (urdf_faults.empty()) {
    readSrdf(file, file.string(), urdf, faults);
  } else {
    faults.insert(faults.end(), urdf_faults.begin(), urdf_faults.end());
  }
}

/// The files that a robot's settings name may have faults of their own besides those of the
/// settings.
void checkNamedFiles(const fs::path& file, const YamlNode& settings,
                     std::vector<FileFault>& faults) {
  const YamlNode* urdf = settings.find("urdf");
  const YamlNode* srdf = settings.find("srdf");
  if (urdf == nullptr || urdf->text.empty()) return;
  const fs::path urdf_file = file.parent_path() / urdf->text;
  if (srdf != nullptr && !srdf->text.empty()) {
    checkSrdf(file.parent_path() / srdf->text, urdf_file, faults);
  } else {
    readUrdf(urdf_file, urdf_file.string(), faults);
  }
}

void checkRobot(const fs::path& file, const YamlNode& document, const fs::path& root,
                std::vector<FileFault>& faults) {
  RobotSettings settings;
  try {
    settings = readRobotSettings(file, root);
  } catch (const FileError& error) {
    faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    return checkNamedFiles(file, document, faults);
  }
  loadRobot(settings);
}

void checkYaml(const fs::path& file, const std::string& text, const fs::path& root,
               std::vector<FileFault>& faults) {
  const YamlNode document = parseYaml(text, file.string());
  const auto has = [&document](const char* key) { return document.find(key) != nullptr; };
  if (has("robots") || has("objects") || has("tasks")) {
    ModelCache models;
    Cell::load(file, root, models);
  } else if (has("urdf") || has("srdf") || has("arms") || has("hands")) {
    checkRobot(file, document, root, faults);
  } else if (has("cells") || has("domain") || has("threads") || has("transport") || has("cache") ||
             has("log_level") || has("profile") || has("discovery_servers")) {
    readDaemonSettings(file);
  } else {
    throw FileError({{file.string(), 0, "is no cell, robot or daemon settings"}});
  }
}

void checkFile(const fs::path& file, const fs::path& root, std::vector<FileFault>& faults) {
  if (isMesh(file)) {
    readConvexMesh(file, Eigen::Vector3d::Ones());
    return;
  }
  const Result<std::string> text = readFileText(file, kMaxMib);
  if (!text) throw FileError({{file.string(), 0, text.error().detail}});
  if (!isXml(*text)) {
    checkYaml(file, *text, root, faults);
  } else if (isSrdf(file, *text)) {
    checkSrdf(file, fs::path(file).replace_extension(".urdf"), faults);
  } else {
    readUrdf(file, file.string(), faults);
  }
}

}  // namespace

std::vector<FileFault> checkFiles(const std::vector<fs::path>& files, const fs::path& root) {
  std::vector<FileFault> faults;
  for (const fs::path& file : files) {
    try {
      checkFile(file, root, faults);
    } catch (const FileError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  return faults;
}

}  // namespace handover
