// SPDX-License-Identifier: Apache-2.0
#include "settings/check.hpp"

#include "core/grasp/hand_model.hpp"
#include "core/model_io/file_text.hpp"
#include "core/model_io/mesh_reader.hpp"
#include "core/model_io/srdf_reader.hpp"
#include "core/model_io/urdf_reader.hpp"
#include "settings/cell_file.hpp"
#include "settings/remarks.hpp"
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

class FileChecker {
 public:
  FileChecker(const fs::path& root, const ConvexDecomposer& divide, CheckReport& report)
      : root_(root), divide_(divide), report_(report), faults_(report.faults) {}

  void check(const fs::path& file) {
    if (isMesh(file)) return checkMesh(file);
    const Result<std::string> text = readFileText(file, kMaxMib);
    if (!text) throw FileError({{file.string(), 0, text.error().detail}});
    if (!isXml(*text)) {
      checkYaml(file, *text);
    } else if (isSrdf(file, *text)) {
      checkSrdf(file, fs::path(file).replace_extension(".urdf"));
    } else {
      readUrdf(file, file.string(), faults_, divide_);
    }
  }

 private:
  void checkMesh(const fs::path& file) {
    BodyShapes body = readMeshBodies(file, Eigen::Vector3d::Ones(), divide_);
    SceneObject object;
    object.shapes = std::move(body.shapes);
    object.divided = std::make_shared<const DividedBodies>(std::move(body.divided));
    Remarks remarks;
    remarkOnShapes(object, "", remarks);
    take(remarks, file);
  }

  void checkSrdf(const fs::path& file, const fs::path& urdf_file) {
    std::error_code error;
    if (!fs::is_regular_file(urdf_file, error)) {
      faults_.push_back({file.string(), 0, "its URDF " + urdf_file.string() + " does not exist"});
      return;
    }
    std::vector<FileFault> urdf_faults;
    const UrdfModel urdf = readUrdf(urdf_file, urdf_file.string(), urdf_faults, divide_);
    if (urdf_faults.empty()) {
      readSrdf(file, file.string(), urdf, faults_);
    } else {
      faults_.insert(faults_.end(), urdf_faults.begin(), urdf_faults.end());
    }
  }

  /// The files that a robot's settings name may have faults of their own besides those of the
  /// settings.
  void checkNamedFiles(const fs::path& file, const YamlNode& settings) {
    const YamlNode* urdf = settings.find("urdf");
    const YamlNode* srdf = settings.find("srdf");
    if (urdf == nullptr || urdf->text.empty()) return;
    const fs::path urdf_file = file.parent_path() / urdf->text;
    if (srdf != nullptr && !srdf->text.empty()) {
      checkSrdf(file.parent_path() / srdf->text, urdf_file);
    } else {
      readUrdf(urdf_file, urdf_file.string(), faults_, divide_);
    }
  }

  void checkRobot(const fs::path& file, const YamlNode& document) {
    RobotSettings settings;
    try {
      settings = readRobotSettings(file, root_);
    } catch (const FileError& error) {
      faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
      return checkNamedFiles(file, document);
    }
    const RobotModel model = loadRobot(settings, divide_);
    Remarks remarks;
    remarkOnRobot(model, restingPosture(model), "", remarks);
    take(remarks, file);
  }

  void checkCell(const fs::path& file) {
    ModelCache models;
    const Cell cell = Cell::load(file, root_, models, divide_);
    append(cell.warnings(), report_.warnings);
    append(cell.facts(), report_.facts);
  }

  void checkYaml(const fs::path& file, const std::string& text) {
    const YamlNode document = parseYaml(text, file.string());
    const auto has = [&document](const char* key) { return document.find(key) != nullptr; };
    if (has("robots") || has("objects") || has("tasks")) {
      checkCell(file);
    } else if (has("urdf") || has("srdf") || has("arms") || has("hands")) {
      checkRobot(file, document);
    } else if (has("cells") || has("domain") || has("threads") || has("transport") ||
               has("cache") || has("limits") || has("log_level") || has("profile") ||
               has("discovery_servers")) {
      checkSettings(file, document);
    } else {
      throw FileError({{file.string(), 0, "is no cell, robot or daemon settings"}});
    }
  }

  void checkSettings(const fs::path& file, const YamlNode& document) {
    const DaemonSettings settings = readDaemonSettings(file);
    append(checkNamedCells(document, file.string(), root_), faults_);
    if (settings.transport == "loopback") return;
    faults_.push_back({file.string(), document.find("transport")->line,
                       "transport: " + settings.transport + " is not built yet"});
  }

  static void append(const std::vector<FileFault>& from, std::vector<FileFault>& to) {
    to.insert(to.end(), from.begin(), from.end());
  }

  void take(const Remarks& remarks, const fs::path& file) {
    append(remarks.warnings.inFile(file.string()), report_.warnings);
    append(remarks.facts.inFile(file.string()), report_.facts);
  }

  const fs::path& root_;
  const ConvexDecomposer& divide_;
  CheckReport& report_;
  std::vector<FileFault>& faults_;
};

}  // namespace

CheckReport checkFiles(const std::vector<fs::path>& files, const fs::path& root,
                       const ConvexDecomposer& divide) {
  CheckReport report;
  FileChecker checker(root, divide, report);
  for (const fs::path& file : files) {
    try {
      checker.check(file);
    } catch (const FileError& error) {
      report.faults.insert(report.faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  return report;
}

}  // namespace handover
