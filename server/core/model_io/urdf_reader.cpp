// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/urdf_reader.hpp"

#include "core/model_io/geometry_shapes.hpp"
#include "core/model_io/urdf_checker.hpp"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace handover {
namespace {

/// urdfdom says why it refuses a file to console_bridge only, whose one handler belongs to the
/// process: this one prints nothing and keeps each thread's first error.
class RefusalLog : public console_bridge::OutputHandler {
 public:
  static std::string& firstError() {
    thread_local std::string text;
    return text;
  }

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level == console_bridge::CONSOLE_BRIDGE_LOG_ERROR && firstError().empty()) {
      firstError() = text;
    }
  }
};

/// An error is a refusal even where a model comes back: a link that urdfdom could not read to its
/// end is in it without its shapes.
urdf::ModelInterfaceSharedPtr parsed(const std::string& text) {
  static RefusalLog log;
  [[maybe_unused]] static const bool used = (console_bridge::useOutputHandler(&log), true);
  RefusalLog::firstError().clear();
  urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(text);
  if (robot == nullptr || !RefusalLog::firstError().empty()) {
    throw std::runtime_error(RefusalLog::firstError());
  }
  return robot;
}

Eigen::Vector3d toVector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Pose toPose(const urdf::Pose& pose) {
  const urdf::Rotation& quat = pose.rotation;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(quat.w, quat.x, quat.y, quat.z).toRotationMatrix();
  X.translation() = toVector(pose.position);
  return X;
}

/// Takes the values from urdfdom, the order and the meshes from the check before it.
class UrdfReader {
 public:
  UrdfReader(const CheckedUrdf& checked, const urdf::ModelInterface& robot,
             const std::string& shown_file, std::vector<FileFault>& faults)
      : checked_(checked), robot_(robot), shown_file_(shown_file), faults_(faults) {}

  UrdfModel read() {
    model_.name = robot_.name_;
    for (const UrdfNode& node : checked_.nodes) {
      Link link;
      link.name = node.link;
      link.parent_joint = JointId(static_cast<int>(model_.links.size()) - 1);
      BodyShapes body;
      for (const auto& collision : robot_.links_.at(node.link)->collision_array) {
        addShapes(*collision, body);
      }
      link.collision = std::move(body.shapes);
      if (!body.divided.empty()) {
        link.divided = std::make_shared<const DividedBodies>(std::move(body.divided));
      }
      if (node.parent >= 0) addJoint(*robot_.joints_.at(node.joint), LinkId(node.parent));
      model_.links.push_back(std::move(link));
    }
    for (Joint& joint : model_.joints) {
      if (joint.mimic && !followMasters(joint)) fault(joint, " mimics itself in the end");
    }
    if (!faults_.empty()) return {};
    for (const Joint& joint : model_.joints) {
      if (joint.mimic) narrowMaster(joint);
    }
    return std::move(model_);
  }

 private:
  void fault(const Joint& mimic, const std::string& message) {
    const int line = checked_.nodes[mimic.child_link].mimic_line;
    faults_.push_back({shown_file_, line, "<joint> '" + mimic.name + "'" + message});
  }

  void addShapes(const urdf::Collision& collision, BodyShapes& body) const {
    const Pose X_LS = toPose(collision.origin);
    const auto add = [&](auto geometry) { body.shapes.push_back({X_LS, std::move(geometry)}); };
    const urdf::Geometry* form = collision.geometry.get();
    if (const auto* box = dynamic_cast<const urdf::Box*>(form)) {
      add(BoxShape{toVector(box->dim)});
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(form)) {
      add(SphereShape{sphere->radius});
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(form)) {
      add(CylinderShape{cylinder->radius, cylinder->length});
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(form)) {
      append(checked_.meshes.at({mesh->filename, {mesh->scale.x, mesh->scale.y, mesh->scale.z}}),
             X_LS, body);
    }
  }

  void addJoint(const urdf::Joint& from, LinkId parent_link) {
    Joint joint;
    joint.name = from.name;
    joint.parent_link = parent_link;
    joint.child_link = LinkId(model_.links.size());
    joint.X_PJ = toPose(from.parent_to_joint_origin_transform);
    if (from.type != urdf::Joint::FIXED) addMotion(from, joint);
    if (joint.type != JointType::kFixed && !joint.mimic) {
      joint.dof = DofId(model_.dof_joints.size());
      model_.dof_joints.push_back(JointId(model_.joints.size()));
    }
    model_.joints.push_back(std::move(joint));
    model_.limit_lines.push_back(checked_.nodes[model_.joints.back().child_link].limit_line);
  }

  static void addMotion(const urdf::Joint& from, Joint& joint) {
    joint.type = from.type == urdf::Joint::PRISMATIC ? JointType::kPrismatic : JointType::kRevolute;
    joint.axis = toVector(from.axis).normalized();
    if (from.limits) {
      joint.lower = from.limits->lower;
      joint.upper = from.limits->upper;
      joint.velocity = from.limits->velocity;
    }
    if (from.type == urdf::Joint::CONTINUOUS) {
      joint.lower = -std::numbers::pi;
      joint.upper = std::numbers::pi;
      joint.continuous = true;
    }
    joint.mimic = from.mimic != nullptr;
  }

  /// Composes the laws up to the joint that mimics none; false if they run in a circle.
  bool followMasters(Joint& joint) const {
    double multiplier = 1, offset = 0;
    const urdf::Joint* at = robot_.joints_.at(joint.name).get();
    for (std::size_t steps = 0; at->mimic; ++steps) {
      if (steps > model_.joints.size()) return false;
      offset += multiplier * at->mimic->offset;
      multiplier *= at->mimic->multiplier;
      at = robot_.joints_.at(at->mimic->joint_name).get();
    }
    const auto master = std::find_if(model_.joints.begin(), model_.joints.end(),
                                     [at](const Joint& j) { return j.name == at->name; });
    joint.dof = master->dof;
    joint.mimic_multiplier = multiplier;
    joint.mimic_offset = offset;
    return true;
  }

  /// A master may go and run only as far and as fast as its mimic joint may.
  void narrowMaster(const Joint& mimic) {
    const double factor = mimic.mimic_multiplier;
    Joint& master = model_.joints[model_.dof_joints[mimic.dof]];
    double lower = mimic.lower - mimic.mimic_offset, upper = mimic.upper - mimic.mimic_offset;
    if (factor == 0) {
      if (lower > 0 || upper < 0) {
        fault(mimic, ": the mimic offset is outside its limits");
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
      fault(mimic,
            ": no position of its master '" + master.name + "' keeps both within their limits");
    }
  }

  const CheckedUrdf& checked_;
  const urdf::ModelInterface& robot_;
  const std::string& shown_file_;
  std::vector<FileFault>& faults_;
  UrdfModel model_;
};

}  // namespace

UrdfModel readUrdf(const std::filesystem::path& file, const std::string& shown_file,
                   std::vector<FileFault>& faults, const ConvexDecomposer& divide) {
  std::vector<FileFault> found;
  UrdfModel model;
  const CheckedUrdf checked = checkUrdf(file, shown_file, found, divide);
  if (found.empty()) {
    try {
      model = UrdfReader(checked, *parsed(checked.text), shown_file, found).read();
    } catch (const std::exception& error) {  // a name that urdfdom reads otherwise, or its refusal
      found.push_back({shown_file, 0, std::string("urdfdom refuses it: ") + error.what()});
    }
  }
  faults.insert(faults.end(), found.begin(), found.end());
  return model;
}

}  // namespace handover
