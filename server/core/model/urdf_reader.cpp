// SPDX-License-Identifier: Apache-2.0
#include "core/model/urdf_reader.hpp"

#include "core/model/mesh_reader.hpp"
#include "core/model/xml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

namespace handover {
namespace {

using tinyxml2::XMLElement;
namespace fs = std::filesystem;

constexpr std::size_t kMaxLinks = 4096;

/// A joint as written: names instead of indices.
struct RawJoint {
  Joint joint;
  std::string parent, child, master;
  int line = 0, mimic_line = 0;
};

struct RawLink {
  Link link;
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

/// Reads one file: the pieces first, then what they make together.
class UrdfReader {
 public:
  UrdfReader(const fs::path& file, const std::string& shown_file, std::vector<FileFault>& faults)
      : folder_(fs::absolute(file).lexically_normal().parent_path()),
        all_faults_(faults),
        faults_(shown_file, faults),
        faults_before_(faults.size()) {}

  UrdfModel read(const fs::path& file) {
    UrdfModel model;
    tinyxml2::XMLDocument document;
    const XMLElement* robot = parseXml(file, document, faults_);
    if (robot == nullptr) return model;
    model.name = requiredText(*robot, "name", faults_);
    for (const XMLElement* e = robot->FirstChildElement("link"); e != nullptr;
         e = e->NextSiblingElement("link")) {
      readLink(*e);
    }
    for (const XMLElement* e = robot->FirstChildElement("joint"); e != nullptr;
         e = e->NextSiblingElement("joint")) {
      readJoint(*e);
    }
    connect(*robot);
    if (clean()) order(model);
    if (clean()) resolveMimics(model);
    return model;
  }

 private:
  bool clean() const { return all_faults_.size() == faults_before_; }

  void readLink(const XMLElement& element) {
    RawLink raw;
    raw.line = element.GetLineNum();
    raw.link.name = requiredText(element, "name", faults_);
    for (const XMLElement* e = element.FirstChildElement("collision"); e != nullptr;
         e = e->NextSiblingElement("collision")) {
      readShape(*e, raw.link.name, &raw.link.collision);
    }
    // Visual shapes are not planned with, but a wrong one is a fault of the file all the same.
    for (const XMLElement* e = element.FirstChildElement("visual"); e != nullptr;
         e = e->NextSiblingElement("visual")) {
      readShape(*e, raw.link.name, nullptr);
    }
    if (raw.link.name.empty()) return;
    const auto [known, added] = link_index_.emplace(raw.link.name, links_.size());
    if (!added) {
      faults_.add(element, described(element) + " is defined twice, first on line " +
                               std::to_string(links_[known->second].line));
      return;
    }
    links_.push_back(std::move(raw));
  }

  /// Adds the shapes of a <collision> or, with no `shapes`, only checks a <visual>.
  void readShape(const XMLElement& element, const std::string& link, std::vector<Shape>* shapes) {
    const Pose X_LS = originOf(element, faults_);
    const std::string at = std::string("<") + element.Name() + "> of link '" + link + "'";
    const XMLElement* geometry = element.FirstChildElement("geometry");
    const XMLElement* form = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (form == nullptr) return faults_.add(element, at + " has no geometry");
    std::vector<Shape> read;
    const std::string_view kind = form->Name();
    if (kind == "box") {
      readBox(*form, at, read);
    } else if (kind == "sphere") {
      if (const auto radius = positive(*form, "radius", at)) add(SphereShape{*radius}, read);
    } else if (kind == "cylinder") {
      const auto radius = positive(*form, "radius", at), length = positive(*form, "length", at);
      if (radius && length) add(CylinderShape{*radius, *length}, read);
    } else if (kind == "mesh") {
      readMesh(*form, at, shapes != nullptr, read);
    } else {
      faults_.add(*form, at + " has unknown geometry <" + std::string(kind) + ">");
    }
    if (shapes == nullptr) return;
    for (Shape& shape : read) {
      shape.X_BS = X_LS * shape.X_BS;
      shapes->push_back(std::move(shape));
    }
  }

  template <typename T>
  static void add(T geometry, std::vector<Shape>& shapes) {
    shapes.push_back(Shape{Pose::Identity(), std::move(geometry)});
  }

  std::optional<double> positive(const XMLElement& form, const char* attribute,
                                 const std::string& at) {
    const std::optional<double> value = requiredNumber(form, attribute, faults_);
    if (!value || *value > 0) return value;
    faults_.add(form, at + ": " + attribute + " of <" + form.Name() + "> must be positive");
    return std::nullopt;
  }

  void readBox(const XMLElement& form, const std::string& at, std::vector<Shape>& shapes) {
    if (form.Attribute("size") == nullptr) return faults_.add(form, "<box> has no size");
    const auto size = vectorOf(form, "size", faults_);
    if (!size) return;
    if (size->minCoeff() <= 0) {
      return faults_.add(form, at + ": size of <box> must be positive");
    }
    add(BoxShape{*size}, shapes);
  }

  void readMesh(const XMLElement& form, const std::string& at, bool load,
                std::vector<Shape>& shapes) {
    const std::string uri = requiredText(form, "filename", faults_);
    Eigen::Vector3d scale = Eigen::Vector3d::Ones();
    if (form.Attribute("scale") != nullptr) {
      const auto given = vectorOf(form, "scale", faults_);
      if (!given) return;
      scale = *given;
    }
    if (scale.cwiseAbs().minCoeff() == 0) {
      return faults_.add(form, at + ": scale of <mesh> must not be zero");
    }
    if (uri.empty()) return;
    if (!knownMeshFormat(uri)) {
      return faults_.add(form, at + ": mesh '" + uri + "' is not STL, OBJ or DAE");
    }
    if (!load) return;
    try {
      shapes = readConvexMesh(meshPath(uri, folder_), scale);
    } catch (const FileError& error) {
      for (const FileFault& fault : error.faults()) {
        faults_.add(form, at + ": mesh '" + uri + "': " + fault.message);
      }
    }
  }

  void readJoint(const XMLElement& element) {
    RawJoint raw;
    raw.line = element.GetLineNum();
    raw.joint.name = requiredText(element, "name", faults_);
    raw.joint.X_PJ = originOf(element, faults_);
    raw.parent = linkNamed(element, "parent");
    raw.child = linkNamed(element, "child");
    const std::string type = requiredText(element, "type", faults_);
    readType(element, type, raw);
    if (raw.joint.type != JointType::kFixed) {
      readAxis(element, raw.joint);
      readLimits(element, type, raw.joint);
      readMimic(element, raw);
    }
    if (raw.joint.name.empty()) return;
    const auto [known, added] = joint_index_.emplace(raw.joint.name, joints_.size());
    if (!added) {
      faults_.add(element, described(element) + " is defined twice, first on line " +
                               std::to_string(joints_[known->second].line));
      return;
    }
    joints_.push_back(std::move(raw));
  }

  void readType(const XMLElement& element, const std::string& type, RawJoint& raw) {
    if (type == "revolute" || type == "continuous") {
      raw.joint.type = JointType::kRevolute;
    } else if (type == "prismatic") {
      raw.joint.type = JointType::kPrismatic;
    } else if (type == "floating" || type == "planar") {
      faults_.add(element, described(element) + ": type '" + type +
                               "' is not supported: a robot's base is fixed by the cell");
    } else if (type != "fixed" && !type.empty()) {
      faults_.add(element, described(element) + ": unknown type '" + type + "'");
    }
  }

  std::string linkNamed(const XMLElement& joint, const char* tag) {
    const XMLElement* end = joint.FirstChildElement(tag);
    if (end == nullptr) {
      faults_.add(joint, described(joint) + " has no <" + tag + ">");
      return "";
    }
    const std::string link = requiredText(*end, "link", faults_);
    if (!link.empty() && !link_index_.contains(link)) {
      faults_.add(*end, described(joint) + ": " + tag + " link '" + link + "' is not defined");
      return "";
    }
    return link;
  }

  void readAxis(const XMLElement& element, Joint& joint) {
    joint.axis = Eigen::Vector3d::UnitX();  // the URDF's default
    const XMLElement* axis = element.FirstChildElement("axis");
    if (axis == nullptr) return;
    if (axis->Attribute("xyz") == nullptr) {
      return faults_.add(*axis, described(element) + ": <axis> has no xyz");
    }
    const auto given = vectorOf(*axis, "xyz", faults_);
    if (!given) return;
    if (given->norm() < 1e-9) return faults_.add(*axis, described(element) + ": axis is zero");
    joint.axis = given->normalized();
  }

  void readLimits(const XMLElement& element, const std::string& type, Joint& joint) {
    const bool turns_freely = type == "continuous";
    if (turns_freely) {
      joint.lower = -std::numbers::pi;
      joint.upper = std::numbers::pi;
    }
    const XMLElement* limit = element.FirstChildElement("limit");
    if (limit == nullptr) {
      if (!turns_freely) faults_.add(element, described(element) + " has no <limit>");
      return;
    }
    joint.velocity = requiredNumber(*limit, "velocity", faults_).value_or(0);
    if (joint.velocity < 0) {
      faults_.add(*limit, described(element) + ": velocity limit is negative");
    }
    if (const auto effort = numberOf(*limit, "effort", faults_); effort && *effort < 0) {
      faults_.add(*limit, described(element) + ": effort limit is negative");
    }
    const auto lower = numberOf(*limit, "lower", faults_),
               upper = numberOf(*limit, "upper", faults_);
    if (turns_freely) return;
    joint.lower = lower.value_or(0);
    joint.upper = upper.value_or(0);
    if (joint.lower > joint.upper) {
      faults_.add(*limit, described(element) + ": lower limit is above the upper one");
    }
  }

  void readMimic(const XMLElement& element, RawJoint& raw) {
    const XMLElement* mimic = element.FirstChildElement("mimic");
    if (mimic == nullptr) return;
    raw.mimic_line = mimic->GetLineNum();
    raw.master = requiredText(*mimic, "joint", faults_);
    raw.joint.mimic = true;
    raw.joint.mimic_multiplier = numberOf(*mimic, "multiplier", faults_).value_or(1);
    raw.joint.mimic_offset = numberOf(*mimic, "offset", faults_).value_or(0);
  }

  /// One parent per link, one root, no loop, mimic masters known.
  void connect(const XMLElement& robot) {
    if (links_.empty()) return faults_.add(robot, described(robot) + " has no link");
    if (links_.size() > kMaxLinks)
      return faults_.add(robot, described(robot) + " has too many links");
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
                                           joints_[static_cast<std::size_t>(parent)].joint.name +
                                           "' and '" + joints_[joint].joint.name + "'");
      return;
    }
    parent = static_cast<int>(joint);
  }

  void checkMaster(const RawJoint& raw) {
    if (raw.master.empty()) return;
    const auto master = joint_index_.find(raw.master);
    const std::string at = "<joint> '" + raw.joint.name + "': mimic master '" + raw.master + "'";
    if (master == joint_index_.end()) {
      faults_.add(raw.mimic_line, at + " is not defined");
    } else if (joints_[master->second].joint.type == JointType::kFixed) {
      faults_.add(raw.mimic_line, at + " is a fixed joint");
    }
  }

  void findRoot(const XMLElement& robot) {
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (parent_joint_[i] < 0) roots.push_back(i);
    }
    for (std::size_t i = 1; i < roots.size(); ++i) {
      faults_.add(links_[roots[i]].line, "link '" + links_[roots[i]].link.name +
                                             "' is a second root beside '" +
                                             links_[roots[0]].link.name + "'");
    }
    if (roots.empty()) return faults_.add(robot, "no link is the root: the joints form a loop");
    root_ = roots[0];
  }

  /// Root first, then depth first in the order in which the joints are written.
  void order(UrdfModel& model) {
    std::vector<std::vector<std::size_t>> joints_below(links_.size());
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      joints_below[link_index_.at(joints_[i].parent)].push_back(i);
    }
    std::vector<int> placed(links_.size(), -1);
    std::vector<std::size_t> waiting{root_};
    while (!waiting.empty()) {
      const std::size_t link = waiting.back();
      waiting.pop_back();
      placed[link] = static_cast<int>(model.links.size());
      place(link, placed, model);
      for (auto it = joints_below[link].rbegin(); it != joints_below[link].rend(); ++it) {
        waiting.push_back(link_index_.at(joints_[*it].child));
      }
    }
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (placed[i] < 0) {
        faults_.add(links_[i].line,
                    "link '" + links_[i].link.name +
                        "' cannot be reached from the root: the joints form a loop");
      }
    }
  }

  void place(std::size_t link, const std::vector<int>& placed, UrdfModel& model) {
    Link ordered = std::move(links_[link].link);
    links_[link].link.name = ordered.name;  // still wanted for messages
    if (const int above = parent_joint_[link]; above >= 0) {
      const RawJoint& raw = joints_[static_cast<std::size_t>(above)];
      Joint joint = raw.joint;
      joint.parent_link = placed[link_index_.at(raw.parent)];
      joint.child_link = static_cast<int>(model.links.size());
      ordered.parent_joint = static_cast<int>(model.joints.size());
      if (joint.type != JointType::kFixed && !joint.mimic) {
        joint.dof = static_cast<int>(model.dof_joints.size());
        model.dof_joints.push_back(ordered.parent_joint);
      }
      model.joints.push_back(std::move(joint));
    }
    model.links.push_back(std::move(ordered));
  }

  void resolveMimics(UrdfModel& model) {
    for (Joint& joint : model.joints) {
      if (joint.mimic && !followMasters(model, joint)) {
        faults_.add(joints_[joint_index_.at(joint.name)].mimic_line,
                    "<joint> '" + joint.name + "' mimics itself in the end");
      }
    }
    if (!clean()) return;
    for (const Joint& joint : model.joints) {
      if (joint.mimic) narrowMaster(model, joint);
    }
  }

  /// Composes the laws up to the joint that mimics none; false if they run in a circle.
  bool followMasters(const UrdfModel& model, Joint& joint) const {
    double multiplier = 1, offset = 0;
    const RawJoint* at = &joints_[joint_index_.at(joint.name)];
    for (std::size_t steps = 0; at->joint.mimic; ++steps) {
      if (steps > joints_.size()) return false;
      offset += multiplier * at->joint.mimic_offset;
      multiplier *= at->joint.mimic_multiplier;
      at = &joints_[joint_index_.at(at->master)];
    }
    const auto master = std::find_if(model.joints.begin(), model.joints.end(),
                                     [at](const Joint& j) { return j.name == at->joint.name; });
    joint.dof = master->dof;
    joint.mimic_multiplier = multiplier;
    joint.mimic_offset = offset;
    return true;
  }

  /// A master may go and run only as far and as fast as its mimic joint may.
  void narrowMaster(UrdfModel& model, const Joint& mimic) {
    const double factor = mimic.mimic_multiplier;
    Joint& master = model.joints[static_cast<std::size_t>(
        model.dof_joints[static_cast<std::size_t>(mimic.dof)])];
    double lower = mimic.lower - mimic.mimic_offset, upper = mimic.upper - mimic.mimic_offset;
    const int line = joints_[joint_index_.at(mimic.name)].mimic_line;
    if (factor == 0) {
      if (lower > 0 || upper < 0) {
        faults_.add(line, "<joint> '" + mimic.name + "': the mimic offset is outside its limits");
      }
      return;
    }
    lower /= factor;
    upper /= factor;
    if (factor < 0) std::swap(lower, upper);
    master.lower = std::max(master.lower, lower);
    master.upper = std::min(master.upper, upper);
    master.velocity = std::min(master.velocity, mimic.velocity / std::abs(factor));
    if (master.lower > master.upper) {
      faults_.add(line, "<joint> '" + mimic.name + "': no position of its master '" + master.name +
                            "' keeps both within their limits");
    }
  }

  fs::path folder_;
  std::vector<FileFault>& all_faults_;
  XmlFaults faults_;
  std::size_t faults_before_;
  std::vector<RawLink> links_;
  std::vector<RawJoint> joints_;
  std::map<std::string, std::size_t> link_index_, joint_index_;
  std::vector<int> parent_joint_;  ///< per link: index in joints_, -1 for a root
  std::size_t root_ = 0;
};

}  // namespace

UrdfModel readUrdf(const fs::path& file, const std::string& shown_file,
                   std::vector<FileFault>& faults) {
  return UrdfReader(file, shown_file, faults).read(file);
}

}  // namespace handover
