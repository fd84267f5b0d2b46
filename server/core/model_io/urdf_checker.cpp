// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/urdf_checker.hpp"

#include "core/model_io/mesh_reader.hpp"
#include "core/model_io/xml_reader.hpp"

#include <handover/common/check.hpp>

#include <limits>
#include <optional>
#include <set>

namespace handover {
namespace {

using tinyxml2::XMLElement;
namespace fs = std::filesystem;

constexpr std::size_t kMaxLinks = 4096, kMaxJoints = bounds::kJoints;  // joints that move
constexpr double kMaxLength = 1000;  // [m]; angles of an origin as well [rad]
constexpr double kMinScale = 1e-6;
constexpr double kMaxLimit = 1e9, kAnyNumber = std::numeric_limits<double>::max();

/// A joint as written.
struct WrittenJoint {
  std::string name, type, parent, child, master;
  int line = 0, mimic_line = 0, limit_line = 0;
};

struct WrittenLink {
  std::string name;
  int line = 0;
};

/// `package://NAME/rest` is the URDF's own package: the folder called NAME that the file lies in,
/// else (whatever NAME says) the URDF's folder.
fs::path meshPath(const std::string& uri, const fs::path& urdf_folder) {
  constexpr std::string_view kPackage = "package://", kFile = "file://";
  if (uri.starts_with(kFile)) return uri.substr(kFile.size());
  if (!uri.starts_with(kPackage)) return urdf_folder / uri;
  const std::string rest = uri.substr(kPackage.size());
  const std::size_t slash = rest.find('/');
  if (slash == std::string::npos) return urdf_folder / rest;
  const fs::path below = rest.substr(slash + 1);
  for (fs::path folder = urdf_folder; folder.has_filename(); folder = folder.parent_path()) {
    if (folder.filename() == rest.substr(0, slash)) return folder / below;
  }
  return urdf_folder / below;
}

bool knownMeshFormat(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension == ".stl" || extension == ".obj" || extension == ".dae";
}

/// Looks at the pieces first, then at what they make together.
class UrdfChecker {
 public:
  UrdfChecker(const fs::path& file, const std::string& shown_file, std::vector<FileFault>& faults,
              const ConvexDecomposer& divide)
      : folder_(fs::absolute(file).lexically_normal().parent_path()),
        all_faults_(faults),
        faults_(shown_file, faults),
        divide_(divide),
        faults_before_(faults.size()) {}

  CheckedUrdf check(const fs::path& file) {
    tinyxml2::XMLDocument document;
    const XMLElement* robot = parseXml(file, document, faults_);
    if (robot == nullptr) return {};
    requiredText(*robot, "name", faults_);
    const char* version = robot->Attribute("version");
    if (version != nullptr && std::string_view(version) != "1.0") {
      faults_.add(*robot, described(*robot) + ": version is not 1.0: '" + version + "'");
    }
    if (tooMany(*robot)) return {};
    forEach(*robot, "material", [this](const XMLElement& e) { checkMaterial(e, true); });
    forEach(*robot, "link", [this](const XMLElement& e) { checkLink(e); });
    forEach(*robot, "joint", [this](const XMLElement& e) { checkJoint(e); });
    connect(*robot);
    if (clean()) order();
    tinyxml2::XMLPrinter text(nullptr, true);
    document.Print(&text);
    checked_.text = text.CStr();
    return std::move(checked_);
  }

 private:
  bool clean() const { return all_faults_.size() == faults_before_; }

  /// Before anything is looked at: there is no end of what may be wrong in a file of any size.
  bool tooMany(const XMLElement& robot) {
    std::size_t links = 0, moving = 0;
    forEach(robot, "link", [&links](const XMLElement&) { ++links; });
    forEach(robot, "joint", [&moving](const XMLElement& e) {
      const char* type = e.Attribute("type");
      if (type == nullptr || std::string_view(type) != "fixed") ++moving;
    });
    const auto check = [&](std::size_t count, std::size_t most, const char* what) {
      if (count <= most) return false;
      faults_.add(robot, described(robot) + " has " + std::to_string(count) + what +
                             ", more than " + std::to_string(most));
      return true;
    };
    const bool links_bad = check(links, kMaxLinks, " links");
    return check(moving, kMaxJoints, " joints that move") || links_bad;
  }

  std::string checkName(const XMLElement& element) {
    std::string name = requiredText(element, "name", faults_);
    if (name.size() > bounds::kName) {
      faults_.add(element, std::string("<") + element.Name() + "> has a name of " +
                               std::to_string(name.size()) + " bytes, more than " +
                               std::to_string(bounds::kName));
    }
    return name;
  }

  /// Colours are not planned with, but urdfdom refuses wrong ones.
  void checkMaterial(const XMLElement& element, bool of_robot) {
    const std::string name = requiredText(element, "name", faults_);
    const XMLElement* color = element.FirstChildElement("color");
    const XMLElement* texture = element.FirstChildElement("texture");
    const bool has_color = color != nullptr && color->Attribute("rgba") != nullptr;
    if (has_color) numbersOf(*color, "rgba", 4, kAnyNumber, faults_);
    const bool defined =
        has_color || (texture != nullptr && texture->Attribute("filename") != nullptr);
    if (name.empty()) return;
    if (of_robot) {
      if (!defined) faults_.add(element, described(element) + " has neither color nor texture");
      if (!materials_.insert(name).second) {
        faults_.add(element, described(element) + " is defined twice");
      }
    } else if (defined) {
      materials_.insert(name);
    } else if (!materials_.contains(name)) {
      faults_.add(element, described(element) + " is not defined");
    }
  }

  void checkInertial(const XMLElement& element, const std::string& at) {
    checkChildren(element, {"origin", "mass", "inertia"}, {}, faults_);
    checkOrigin(element, faults_);
    const XMLElement* mass = element.FirstChildElement("mass");
    const XMLElement* inertia = element.FirstChildElement("inertia");
    if (mass == nullptr) faults_.add(element, at + " has no <mass>");
    if (inertia == nullptr) faults_.add(element, at + " has no <inertia>");
    if (mass != nullptr) {
      const auto value = requiredNumber(*mass, "value", faults_, kAnyNumber);
      if (value && *value < 0) faults_.add(*mass, at + ": mass is negative");
    }
    if (inertia == nullptr) return;
    for (const char* moment : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) {
      requiredNumber(*inertia, moment, faults_, kAnyNumber);
    }
  }

  void checkLink(const XMLElement& element) {
    const std::string name = checkName(element);
    checkChildren(element, {"inertial"},
                  {"visual", "collision", "contact", "sensor", "gravity", "audio_source",
                   "collision_checking", "self_collision_checking"},
                  faults_);
    const std::string of = "> of link '" + name + "'";
    forEach(element, "inertial", [&](const XMLElement& e) { checkInertial(e, "<inertial" + of); });
    forEach(element, "collision",
            [&](const XMLElement& e) { checkShape(e, "<collision" + of, true); });
    // Visual shapes are not planned with, but a wrong one is a fault of the file all the same.
    forEach(element, "visual", [&](const XMLElement& e) { checkShape(e, "<visual" + of, false); });
    if (name.empty()) return;
    const auto [known, added] = link_index_.emplace(name, links_.size());
    if (!added) return addTwice(element, links_[known->second].line);
    links_.push_back({name, element.GetLineNum()});
  }

  void addTwice(const XMLElement& element, int first_line) {
    faults_.add(element, described(element) + " is defined twice, first on line " +
                             std::to_string(first_line));
  }

  void checkShape(const XMLElement& element, const std::string& at, bool load) {
    checkChildren(element, {"origin", "geometry", "material"}, {"verbose", "contact_coefficients"},
                  faults_);
    forEach(element, "material", [this](const XMLElement& e) { checkMaterial(e, false); });
    checkOrigin(element, faults_);
    const XMLElement* geometry = element.FirstChildElement("geometry");
    const XMLElement* form = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (form == nullptr) return faults_.add(element, at + " has no geometry");
    if (form->NextSiblingElement() != nullptr) {
      faults_.add(*form->NextSiblingElement(), at + " has two shapes");
    }
    const std::string_view kind = form->Name();
    if (kind == "box") {
      checkBox(*form, at);
    } else if (kind == "sphere" || kind == "cylinder") {
      checkAttributes(*form, {"radius", kind == "cylinder" ? "length" : "radius"}, faults_);
      checkPositive(*form, "radius", at);
      if (kind == "cylinder") checkPositive(*form, "length", at);
    } else if (kind == "mesh") {
      checkMesh(*form, at, load);
    } else {
      faults_.add(*form, at + " has unknown geometry <" + std::string(kind) + ">");
    }
  }

  void checkPositive(const XMLElement& form, const char* attribute, const std::string& at) {
    const std::optional<double> value = requiredNumber(form, attribute, faults_, kMaxLength);
    if (!value || *value > 0) return;
    faults_.add(form, at + ": " + attribute + " of <" + form.Name() + "> must be positive");
  }

  void checkBox(const XMLElement& form, const std::string& at) {
    checkAttributes(form, {"size"}, faults_);
    if (form.Attribute("size") == nullptr) return faults_.add(form, "<box> has no size");
    const auto size = vectorOf(form, "size", faults_);
    if (size && size->minCoeff() <= 0) {
      faults_.add(form, at + ": size of <box> must be positive");
    }
  }

  void checkMesh(const XMLElement& form, const std::string& at, bool load) {
    checkAttributes(form, {"filename", "scale"}, faults_);
    const std::string uri = requiredText(form, "filename", faults_);
    Eigen::Vector3d scale = Eigen::Vector3d::Ones();
    if (form.Attribute("scale") != nullptr) {
      const auto given = vectorOf(form, "scale", faults_, kMaxLength);
      if (!given) return;
      scale = *given;
    }
    if (scale.cwiseAbs().minCoeff() < kMinScale) {
      return faults_.add(form, at + ": scale of <mesh> must not be zero");
    }
    if (uri.empty()) return;
    if (!knownMeshFormat(uri)) {
      return faults_.add(form, at + ": mesh '" + uri + "' is not STL, OBJ or DAE");
    }
    const std::pair key(uri, std::array{scale.x(), scale.y(), scale.z()});
    if (!load || checked_.meshes.contains(key)) return;
    const fs::path mesh = meshPath(uri, folder_);
    if (const std::string fault = meshes_.add(mesh); !fault.empty()) {
      return faults_.add(form, at + ": " + fault);
    }
    try {
      checked_.meshes.emplace(key, readMeshBodies(mesh, scale, divide_, importer_));
    } catch (const FileError& error) {
      for (const FileFault& fault : error.faults()) {
        const std::string line = fault.line > 0 ? ":" + std::to_string(fault.line) : "";
        faults_.add(form, at + ": mesh '" + uri + "'" + line + ": " + fault.message);
      }
    }
  }

  void checkJoint(const XMLElement& element) {
    WrittenJoint joint;
    joint.line = element.GetLineNum();
    joint.name = checkName(element);
    checkAttributes(element, {"name", "type"}, faults_);
    checkChildren(element,
                  {"origin", "parent", "child", "axis", "limit", "mimic", "dynamics", "calibration",
                   "safety_controller"},
                  {}, faults_);
    checkOrigin(element, faults_);
    joint.parent = linkNamed(element, "parent");
    joint.child = linkNamed(element, "child");
    if (!joint.parent.empty() && joint.parent == joint.child) {
      faults_.add(element, described(element) + " joins link '" + joint.parent + "' to itself");
    }
    joint.type = requiredText(element, "type", faults_);
    checkType(element, joint.type);
    checkAxis(element, joint.type);
    checkLimits(element, joint);
    checkMimic(element, joint);
    checkExtras(element);
    if (joint.name.empty()) return;
    const auto [known, added] = joint_index_.emplace(joint.name, joints_.size());
    if (!added) return addTwice(element, joints_[known->second].line);
    joints_.push_back(std::move(joint));
  }

  void checkType(const XMLElement& element, const std::string& type) {
    if (type == "floating" || type == "planar") {
      faults_.add(element, described(element) + ": type '" + type +
                               "' is not supported: a robot's base is fixed by the cell");
    } else if (type != "fixed" && type != "revolute" && type != "continuous" &&
               type != "prismatic" && !type.empty()) {
      faults_.add(element, described(element) + ": unknown type '" + type + "'");
    }
  }

  std::string linkNamed(const XMLElement& joint, const char* tag) {
    const XMLElement* end = joint.FirstChildElement(tag);
    if (end == nullptr) {
      faults_.add(joint, described(joint) + " has no <" + tag + ">");
      return "";
    }
    checkAttributes(*end, {"link"}, faults_);
    std::string link = requiredText(*end, "link", faults_);
    if (!link.empty() && !link_index_.contains(link)) {
      faults_.add(*end, described(joint) + ": " + tag + " link '" + link + "' is not defined");
      return "";
    }
    return link;
  }

  void checkAxis(const XMLElement& element, const std::string& type) {
    const XMLElement* axis = element.FirstChildElement("axis");
    if (axis == nullptr || type == "fixed") return;
    checkAttributes(*axis, {"xyz"}, faults_);
    if (axis->Attribute("xyz") == nullptr) {
      return faults_.add(*axis, described(element) + ": <axis> has no xyz");
    }
    const auto given = vectorOf(*axis, "xyz", faults_, kAnyNumber);
    if (given && given->norm() < 1e-9) faults_.add(*axis, described(element) + ": axis is zero");
  }

  void checkLimits(const XMLElement& element, WrittenJoint& joint) {
    const std::string& type = joint.type;
    const bool bounded = type == "revolute" || type == "prismatic";
    const XMLElement* limit = element.FirstChildElement("limit");
    if (limit == nullptr) {
      if (bounded) faults_.add(element, described(element) + " has no <limit>");
      return;
    }
    joint.limit_line = limit->GetLineNum();
    checkAttributes(
        *limit, {"lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"},
        faults_);
    for (const char* kind : {"velocity", "effort"}) {
      const auto value = requiredNumber(*limit, kind, faults_, kAnyNumber);
      if (value && *value < 0) {
        faults_.add(*limit, described(element) + ": " + kind + " limit is negative");
      }
    }
    const double most = type == "revolute"    ? kMaxLimit
                        : type == "prismatic" ? kMaxLength
                                              : kAnyNumber;
    const auto lower = numberOf(*limit, "lower", faults_, most),
               upper = numberOf(*limit, "upper", faults_, most);
    if (bounded && lower.value_or(0) > upper.value_or(0)) {
      faults_.add(*limit, described(element) + ": lower limit is above the upper one");
    }
  }

  void checkMimic(const XMLElement& element, WrittenJoint& joint) {
    const XMLElement* mimic = element.FirstChildElement("mimic");
    if (mimic == nullptr) return;
    checkAttributes(*mimic, {"joint", "multiplier", "offset"}, faults_);
    if (joint.type == "fixed") faults_.add(*mimic, described(element) + " is fixed and mimics");
    joint.mimic_line = mimic->GetLineNum();
    joint.master = requiredText(*mimic, "joint", faults_);
    numberOf(*mimic, "multiplier", faults_, kMaxLimit);
    numberOf(*mimic, "offset", faults_, kMaxLimit);
  }

  /// Not planned with, but urdfdom refuses them without a line when they are wrong.
  void checkExtras(const XMLElement& element) {
    if (const XMLElement* dynamics = element.FirstChildElement("dynamics")) {
      for (const char* kind : {"damping", "friction"}) {
        numberOf(*dynamics, kind, faults_, kAnyNumber);
      }
      if (dynamics->Attribute("damping") == nullptr && dynamics->Attribute("friction") == nullptr) {
        faults_.add(*dynamics, described(element) + ": <dynamics> has no damping and no friction");
      }
    }
    if (const XMLElement* calibration = element.FirstChildElement("calibration")) {
      for (const char* edge : {"rising", "falling"}) {
        numberOf(*calibration, edge, faults_, kAnyNumber);
      }
    }
    if (const XMLElement* safety = element.FirstChildElement("safety_controller")) {
      requiredNumber(*safety, "k_velocity", faults_, kAnyNumber);
      for (const char* kind : {"soft_lower_limit", "soft_upper_limit", "k_position"}) {
        numberOf(*safety, kind, faults_, kAnyNumber);
      }
    }
  }

  /// One parent per link, one root, no loop, mimic masters known.
  void connect(const XMLElement& robot) {
    if (links_.empty()) return faults_.add(robot, described(robot) + " has no link");
    parent_joint_.assign(links_.size(), -1);
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (!joints_[i].child.empty()) claimChild(i);
      checkMaster(joints_[i]);
    }
    if (!clean()) return;  // missing links would show up as further roots
    findRoot(robot);
  }

  void claimChild(std::size_t joint) {
    int& parent = parent_joint_[link_index_.at(joints_[joint].child)];
    if (parent >= 0) {
      faults_.add(joints_[joint].line, "link '" + joints_[joint].child +
                                           "' is the child of two joints: '" +
                                           joints_[static_cast<std::size_t>(parent)].name +
                                           "' and '" + joints_[joint].name + "'");
      return;
    }
    parent = static_cast<int>(joint);
  }

  void checkMaster(const WrittenJoint& joint) {
    if (joint.master.empty()) return;
    const auto master = joint_index_.find(joint.master);
    const std::string at = "<joint> '" + joint.name + "': mimic master '" + joint.master + "'";
    if (master == joint_index_.end()) {
      faults_.add(joint.mimic_line, at + " is not defined");
    } else if (joints_[master->second].type == "fixed") {
      faults_.add(joint.mimic_line, at + " is a fixed joint");
    }
  }

  void findRoot(const XMLElement& robot) {
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (parent_joint_[i] < 0) roots.push_back(i);
    }
    for (std::size_t i = 1; i < roots.size(); ++i) {
      faults_.add(links_[roots[i]].line, "link '" + links_[roots[i]].name +
                                             "' is a second root beside '" + links_[roots[0]].name +
                                             "'");
    }
    if (roots.empty()) return faults_.add(robot, "no link is the root: the joints form a loop");
    root_ = roots[0];
  }

  /// Root first, then depth first in the order in which the joints are written.
  void order() {
    std::vector<std::vector<std::size_t>> joints_below(links_.size());
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      joints_below[link_index_.at(joints_[i].parent)].push_back(i);
    }
    std::vector<int> placed(links_.size(), -1);
    std::vector<std::size_t> waiting{root_};
    while (!waiting.empty()) {
      const std::size_t link = waiting.back();
      waiting.pop_back();
      placed[link] = static_cast<int>(checked_.nodes.size());
      UrdfNode node{links_[link].name, "", -1, 0, 0};
      if (parent_joint_[link] >= 0) {
        const WrittenJoint& above = joints_[static_cast<std::size_t>(parent_joint_[link])];
        node = {node.link, above.name, placed[link_index_.at(above.parent)], above.mimic_line,
                above.limit_line};
      }
      checked_.nodes.push_back(std::move(node));
      for (auto it = joints_below[link].rbegin(); it != joints_below[link].rend(); ++it) {
        waiting.push_back(link_index_.at(joints_[*it].child));
      }
    }
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (placed[i] >= 0) continue;
      faults_.add(links_[i].line, "link '" + links_[i].name +
                                      "' cannot be reached from the root: the joints form a loop");
    }
  }

  fs::path folder_;
  std::vector<FileFault>& all_faults_;
  XmlFaults faults_;
  const ConvexDecomposer& divide_;
  std::size_t faults_before_;
  CheckedUrdf checked_;
  std::vector<WrittenLink> links_;
  std::vector<WrittenJoint> joints_;
  std::map<std::string, std::size_t> link_index_, joint_index_;
  std::set<std::string> materials_;
  MeshTotal meshes_;
  MeshImporter importer_;
  std::vector<int> parent_joint_;  ///< per link: index in joints_, -1 for a root
  std::size_t root_ = 0;
};

}  // namespace

CheckedUrdf checkUrdf(const fs::path& file, const std::string& shown_file,
                      std::vector<FileFault>& faults, const ConvexDecomposer& divide) {
  return UrdfChecker(file, shown_file, faults, divide).check(file);
}

}  // namespace handover
