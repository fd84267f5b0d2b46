// SPDX-License-Identifier: Apache-2.0
#include "settings/scene_resolver.hpp"

#include "core/kinematics/arm_kinematics.hpp"
#include "core/model/joint_limits.hpp"
#include "core/model_io/geometry_shapes.hpp"
#include "core/model_io/mesh_reader.hpp"

#include <algorithm>
#include <set>

namespace handover {
namespace {

constexpr int kSwivelSamples = 64;

class SceneResolver {
 public:
  SceneResolver(const CellDescription& cell, const ModelCache& models,
                const std::filesystem::path& root, const ConvexDecomposer& divide,
                const std::map<std::string, KnownShapes>& known, YamlReport& report)
      : cell_(cell),
        models_(models),
        root_(root),
        divide_(divide),
        known_(known),
        report_(report) {}

  ResolvedCell resolve() {
    scene().cell = cell_.name;
    checkNames();
    for (const RobotDescription& robot : cell_.robots) addRobot(robot);
    if (scene().robots.size() != cell_.robots.size()) return std::move(out_);  // poses need them
    for (const ObjectDescription& object : cell_.objects) addObject(object);
    robot_states_.assign(cell_.robots.size(), State::kOpen);
    object_states_.assign(cell_.objects.size(), State::kOpen);
    X_WL_.resize(cell_.robots.size());
    for (std::size_t i = 0; i < cell_.robots.size(); ++i) placeRobot(i);
    for (std::size_t i = 0; i < cell_.objects.size(); ++i) placeObject(i);
    for (const RobotDescription& robot : cell_.robots) addRobotResting(robot);
    for (const TaskDescription& task : cell_.tasks) addTask(task);
    return std::move(out_);
  }

 private:
  enum class State { kOpen, kBusy, kPlaced };

  Scene& scene() { return out_.scene; }

  void checkNames() {
    if (cell_.robots.empty()) report_.add("robots", "is empty");
    if (cell_.tasks.empty()) report_.add("tasks", "is empty");
    if (robotNamed("world").valid()) report_.add("robots.world", "'world' is the world's own name");
    for (const ObjectDescription& object : cell_.objects) {
      const std::string path = "objects." + object.name;
      if (object.name == "world") report_.add(path, "'world' is the world's own name");
      if (robotNamed(object.name).valid()) report_.add(path, "is the name of a robot too");
    }
  }

  std::string noRobot(const std::string& name) const {
    return "no robot '" + name + "' in this cell" + nearestNamed(cell_.robots, name);
  }

  RobotId robotNamed(const std::string& name) const {
    for (const RobotId i : IdRange<RobotId>(cell_.robots.size())) {
      if (cell_.robots[i].name == name) return i;
    }
    return {};
  }

  ObjectId objectNamed(const std::string& name, const std::string& path) {
    for (const ObjectId i : IdRange<ObjectId>(cell_.objects.size())) {
      if (cell_.objects[i].name == name) return i;
    }
    report_.add(path, "no object '" + name + "' in this cell" + nearestNamed(cell_.objects, name));
    return {};
  }

  LinkId linkNamed(const RobotModel& model, const std::string& name, const std::string& path) {
    const LinkId link = model.findLink(name);
    if (!link.valid()) {
      report_.add(path, "link '" + name + "' is not in robot '" + model.name + "'" +
                            nearestNamed(model.links, name));
    }
    return link;
  }

  // ---- robots

  void addRobot(const RobotDescription& description) {
    const std::string path = "robots." + description.name;
    SceneRobot robot;
    robot.name = description.name;
    const auto model = models_.find(description.model);
    if (model == models_.end()) {
      return report_.add(path + ".model",
                         "model '" + description.model + "' was not loaded with this cell");
    }
    robot.model = model->second;
    robot.q_start = posture(description, *robot.model, path);
    setJoints(description, path + ".joints", robot);
    for (const auto& [arm, X_BT] : description.tools) setTool(arm, X_BT, path, robot);
    scene().robots.push_back(std::move(robot));
  }

  RobotVector posture(const RobotDescription& description, const RobotModel& model,
                      const std::string& path) {
    RobotVector q(model.dofs());
    for (const DofId dof : IdRange<DofId>(model.dofs())) {
      const Joint& joint = model.joints[model.dof_joints[dof]];
      q[dof.value()] = std::clamp(0.0, joint.lower, joint.upper);
    }
    if (description.posture.empty()) return q;
    const auto state = model.named_states.find(description.posture);
    if (state != model.named_states.end()) return state->second;
    std::set<std::string> names;
    for (const auto& [name, positions] : model.named_states) names.insert(name);
    report_.add(path + ".posture", "'" + description.posture + "' is no group state of robot '" +
                                       model.name + "'" +
                                       nearestSaid(nearestOf(names, description.posture)));
    return q;
  }

  void setJoints(const RobotDescription& description, const std::string& path, SceneRobot& robot) {
    for (const auto& [name, position] : description.joints) {
      const std::string at = path + "." + name;
      const JointId index = robot.model->findJoint(name);
      if (!index.valid()) {
        report_.add(at, "no such joint in robot '" + robot.model->name + "'" +
                            nearestNamed(robot.model->joints, name));
        continue;
      }
      const Joint& joint = robot.model->joints[static_cast<std::size_t>(index)];
      if (joint.type == JointType::kFixed || joint.mimic) {
        report_.add(at, joint.mimic ? "mimics another joint" : "is fixed");
      } else if (!withinWrittenLimits(joint, position)) {
        report_.add(at, "is outside the joint's limits: " + besideLimits(joint, position));
      } else {
        robot.q_start[joint.dof.value()] = std::clamp(position, joint.lower, joint.upper);
      }
    }
  }

  /// Solves an arm for a tool pose X_BT: of all solutions the nearest to the posture so far.
  void setTool(const std::string& arm_name, const Pose& X_BT, const std::string& path,
               SceneRobot& robot) {
    const RobotModel& model = *robot.model;
    const std::string at = path + ".arms." + arm_name;
    const ArmId arm_index = model.findArm(arm_name);
    if (!arm_index.valid()) {
      return report_.add(
          at, "robot '" + model.name + "' has no such arm" + nearestNamed(model.arms, arm_name));
    }
    const Arm& arm = model.arms[arm_index];
    std::vector<Pose> X_BL;
    linkPoses(model, Pose::Identity(), robot.q_start, X_BL);
    IkQuery query;
    query.swivel_samples = kSwivelSamples;
    query.q_near.resize(static_cast<Eigen::Index>(arm.dofs.size()));
    for (std::size_t i = 0; i < arm.dofs.size(); ++i) {
      query.q_near[static_cast<Eigen::Index>(i)] = robot.q_start[arm.dofs[i].value()];
    }
    std::vector<ArmVector> solutions;
    const Pose X_AT = X_BL[arm.base_link].inverse() * X_BT;
    ArmKinematics(model, arm_index).solve(X_AT, query, solutions);
    const auto nearest = std::min_element(solutions.begin(), solutions.end(),
                                          [&query](const ArmVector& a, const ArmVector& b) {
                                            return (a - query.q_near).lpNorm<Eigen::Infinity>() <
                                                   (b - query.q_near).lpNorm<Eigen::Infinity>();
                                          });
    if (nearest == solutions.end()) {
      return report_.add(at + ".tool", "arm '" + arm_name + "' of robot '" + robot.name +
                                           "' cannot reach this pose within its limits");
    }
    for (std::size_t i = 0; i < arm.dofs.size(); ++i) {
      robot.q_start[arm.dofs[i].value()] = (*nearest)[static_cast<Eigen::Index>(i)];
    }
  }

  void addRobotResting(const RobotDescription& description) {
    SceneRobot& robot = scene().robots[robotNamed(description.name)];
    const std::string path = "robots." + description.name + ".resting";
    for (const auto& [link_name, object] : description.resting) {
      const LinkId link = linkNamed(*robot.model, link_name, path);
      if (link.valid() && objectNamed(object, path).valid())
        robot.resting.emplace_back(link, object);
    }
  }

  // ---- objects

  void addObject(const ObjectDescription& description) {
    const std::string path = "objects." + description.name;
    SceneObject object;
    object.name = description.name;
    object.geometry = description.geometry;
    setShapes(description, path + ".geometry", object);
    for (const std::string& other : description.resting) {
      if (!objectNamed(other, path + ".resting").valid()) continue;
      if (other == description.name) report_.add(path + ".resting", "rests on itself");
      object.resting.push_back(other);
    }
    if (description.attached_to) attach(*description.attached_to, path + ".attached_to", object);
    addGraspCounts(description, path + ".grasps", object);
    scene().objects.push_back(std::move(object));
  }

  void setShapes(const ObjectDescription& description, const std::string& path,
                 SceneObject& object) {
    const auto known = known_.find(description.name);
    if (known != known_.end() && known->second.geometry == description.geometry) {
      object.shapes = known->second.shapes;
      object.divided = known->second.divided;
      return;
    }
    if (const std::string fault = countMeshes(description.geometry); !fault.empty()) {
      return report_.add(path, fault);
    }
    try {
      BodyShapes body = bodyShapesOf(description.geometry, root_, divide_, importer_);
      object.shapes = std::move(body.shapes);
      if (body.divided.empty()) return;
      object.divided = std::make_shared<const DividedBodies>(std::move(body.divided));
    } catch (const FileError& error) {
      for (const FileFault& fault : error.faults()) report_.add(path, fault.text());
    }
  }

  /// What is wrong if all so far are too many, else empty.
  std::string countMeshes(const Geometry& geometry) {
    if (const auto* mesh = std::get_if<MeshGeometry>(&geometry)) {
      return meshes_.add(root_ / mesh->path);
    }
    if (const auto* compound = std::get_if<CompoundGeometry>(&geometry)) {
      for (const GeometryPart& part : compound->parts) {
        if (std::string fault = countMeshes(part.geometry); !fault.empty()) return fault;
      }
    }
    return {};
  }

  void attach(const AttachmentDescription& description, const std::string& path,
              SceneObject& object) {
    Attachment attachment;
    attachment.robot = robotNamed(description.robot);
    if (!attachment.robot.valid()) {
      return report_.add(path + ".robot", noRobot(description.robot));
    }
    const RobotModel& model = *scene().robots[attachment.robot].model;
    attachment.link = linkNamed(model, description.link, path + ".link");
    attachment.X_LO = description.X_LO;
    for (const std::string& name : description.touch_links) {
      attachment.touch_links.push_back(linkNamed(model, name, path + ".touch_links"));
    }
    object.attached_to = std::move(attachment);
  }

  void addGraspCounts(const ObjectDescription& description, const std::string& path,
                      SceneObject& object) {
    for (const auto& [robot_name, hands] : description.grasp_counts) {
      const RobotId robot = robotNamed(robot_name);
      if (!robot.valid()) {
        report_.add(path + "." + robot_name, noRobot(robot_name));
        continue;
      }
      const RobotModel& model = *scene().robots[robot].model;
      for (const auto& [hand, count] : hands) {
        if (model.findHand(hand).valid()) continue;
        report_.add(
            path + "." + robot_name + "." + hand,
            "robot '" + robot_name + "' has no such hand" + nearestNamed(model.hands, hand));
      }
    }
    object.grasp_counts = description.grasp_counts;
  }

  // ---- poses in the world: what a pose is given in is placed first

  /// False, with the fault said once, if the robot cannot be placed.
  bool placeRobot(std::size_t index) {
    if (robot_states_[index] == State::kPlaced) return true;
    const RobotDescription& description = cell_.robots[index];
    const std::string path = "robots." + description.name + ".base";
    if (robot_states_[index] == State::kBusy) return inACircle(path);
    robot_states_[index] = State::kBusy;
    SceneRobot& robot = scene().robots[index];
    const auto X_WB = inWorld(description.base, path);
    robot.X_WB = X_WB.value_or(Pose::Identity());
    linkPoses(*robot.model, robot.X_WB, robot.q_start, X_WL_[index]);
    robot_states_[index] = State::kPlaced;
    return X_WB.has_value();
  }

  bool placeObject(std::size_t index) {
    if (object_states_[index] == State::kPlaced) return true;
    const ObjectDescription& description = cell_.objects[index];
    const std::string path = "objects." + description.name;
    if (object_states_[index] == State::kBusy) return inACircle(path + ".pose");
    object_states_[index] = State::kBusy;
    SceneObject& object = scene().objects[index];
    std::optional<Pose> X_WO;
    if (object.attached_to && object.attached_to->link.valid()) {
      if (placeRobot(object.attached_to->robot)) {
        X_WO = linkPose(object.attached_to->robot, object.attached_to->link) *
               object.attached_to->X_LO;
      }
    } else if (description.pose) {
      X_WO = inWorld(*description.pose, path + ".pose");
    }
    object.X_WO = X_WO.value_or(Pose::Identity());
    object_states_[index] = State::kPlaced;
    return X_WO.has_value();
  }

  bool inACircle(const std::string& path) {
    report_.add(path + ".frame", "cyclic frame reference");
    return false;
  }

  /// @pre the robot is placed.
  const Pose& linkPose(RobotId robot, LinkId link) const { return X_WL_[robot][link]; }

  /// What a pose can be given in, links apart.
  std::set<std::string> frameNames() const {
    std::set<std::string> names{"world"};
    for (const ObjectDescription& object : cell_.objects) names.insert(object.name);
    for (const RobotDescription& robot : cell_.robots) names.insert(robot.name);
    return names;
  }

  std::optional<Pose> inWorld(const FramedPose& pose, const std::string& path) {
    if (pose.frame == "world") return pose.X_FO;
    for (std::size_t i = 0; i < cell_.objects.size(); ++i) {
      if (cell_.objects[i].name != pose.frame) continue;
      if (!placeObject(i)) return std::nullopt;
      return scene().objects[i].X_WO * pose.X_FO;
    }
    const std::size_t slash = pose.frame.find('/');
    const RobotId robot = robotNamed(pose.frame.substr(0, slash));
    if (!robot.valid()) {
      report_.add(path + ".frame", "'" + pose.frame +
                                       "' is neither world, an object, a robot nor robot/link" +
                                       nearestSaid(nearestOf(frameNames(), pose.frame)));
      return std::nullopt;
    }
    if (!placeRobot(robot)) return std::nullopt;
    if (slash == std::string::npos) return linkPose(robot, LinkId(0)) * pose.X_FO;
    const RobotModel& model = *scene().robots[robot].model;
    const LinkId link = linkNamed(model, pose.frame.substr(slash + 1), path + ".frame");
    if (!link.valid()) return std::nullopt;
    return linkPose(robot, link) * pose.X_FO;
  }

  // ---- tasks

  void addTask(const TaskDescription& description) {
    const std::string path = "tasks." + description.name;
    SceneTask task;
    task.name = description.name;
    task.object = description.object;
    task.end = description.end;
    task.upright = description.upright;
    for (std::size_t i = 0; i < description.chain.size(); ++i) {
      const char* key = i == 0 ? ".giver" : ".receiver";
      task.chain.push_back(holderNamed(description.chain[i],
                                       path + (description.giver_and_receiver ? key : ".chain")));
    }
    checkChain(task, path + (description.giver_and_receiver ? ".receiver" : ".chain"));
    const ObjectId object = objectNamed(description.object, path + ".object");
    if (!object.valid()) return;
    if (scene().objects[object].attached_to) {
      report_.add(path + ".object", "'" + description.object + "' is attached to a robot");
    }
    task.X_WO_start = scene().objects[object].X_WO;
    if (description.start) place(*description.start, description, path + ".start", task.X_WO_start);
    if (!description.held_by.empty()) addHeldBy(description, path, task);
    place(description.goal, description, path + ".goal", task.X_WO_goal);
    addRests(description, path, task);
    out_.tasks.push_back(std::move(task));
  }

  /// `robot` or `robot/arm`; a fault, and no robot, for unknown names.
  ChainHolder holderNamed(const std::string& name, const std::string& path) {
    const std::size_t slash = name.find('/');
    const std::string robot_name = name.substr(0, slash);
    ChainHolder holder{robotNamed(robot_name), {}};
    if (!holder.robot.valid()) {
      report_.add(path, noRobot(robot_name));
      return holder;
    }
    const RobotModel& model = *scene().robots[holder.robot].model;
    if (slash == std::string::npos) {
      if (model.arms.empty()) report_.add(path, "robot '" + robot_name + "' has no arm");
      return holder;
    }
    const std::string arm = name.substr(slash + 1);
    holder.arm = model.findArm(arm);
    if (!holder.arm.valid()) {
      report_.add(path, "robot '" + robot_name + "' has no arm '" + arm + "'" +
                            nearestNamed(model.arms, arm));
    }
    return holder;
  }

  void checkChain(const SceneTask& task, const std::string& path) {
    for (std::size_t i = 1; i < task.chain.size(); ++i) {
      const ChainHolder& a = task.chain[i - 1];
      const ChainHolder& b = task.chain[i];
      if (!a.robot.valid() || a.robot != b.robot) continue;
      const RobotModel& model = *scene().robots[a.robot].model;
      if ((a.arm.valid() && a.arm == b.arm) || model.arms.size() < 2) {
        report_.add(path, "successive holders must be different arms");
      }
    }
  }

  void addHeldBy(const TaskDescription& description, const std::string& path, SceneTask& task) {
    const ChainHolder holder = holderNamed(description.held_by, path + ".start.held_by");
    if (!holder.robot.valid()) return;
    if (!holder.arm.valid()) {
      if (description.held_by.find('/') == std::string::npos) {
        report_.add(path + ".start.held_by", "must name the arm: robot/arm");
      }
      return;
    }
    task.held_by = holder;
  }

  void place(const FramedPose& pose, const TaskDescription& task, const std::string& path,
             Pose& X_WO) {
    if (pose.frame == task.object) {
      return report_.add(path + ".frame", "is the task's own object");
    }
    if (const auto placed = inWorld(pose, path)) X_WO = *placed;
  }

  /// By default an object rests on the one whose frame its start or goal is given in; at its start
  /// where the scene has it, on what the scene says.
  void addRests(const TaskDescription& task, const std::string& path, SceneTask& out) {
    const auto isObject = [&](const std::string& frame) {
      return scene().findObject(frame).valid();
    };
    const ObjectId object = scene().findObject(task.object);
    const std::vector<std::string>& resting = scene().objects[object].resting;
    if (task.start_rest) {
      out.start_rest = restOf(*task.start_rest, task, path + ".start_rest");
    } else if (task.start && isObject(task.start->frame)) {
      out.start_rest.objects = {task.start->frame};
    } else if (!task.start && !resting.empty()) {
      out.start_rest.objects = resting;
    }
    if (task.goal_rest) {
      out.goal_rest = restOf(*task.goal_rest, task, path + ".goal_rest");
    } else if (isObject(task.goal.frame)) {
      out.goal_rest.objects = {task.goal.frame};
    }
  }

  TaskRest restOf(const RestDescription& rest, const TaskDescription& task,
                  const std::string& path) {
    if (rest.none) return {true, std::nullopt};
    std::vector<std::string> objects;
    for (const std::string& name : rest.objects) {
      if (!objectNamed(name, path).valid()) continue;
      if (name == task.object) report_.add(path, "rests on itself");
      objects.push_back(name);
    }
    return {false, std::move(objects)};
  }

  const CellDescription& cell_;
  const ModelCache& models_;
  const std::filesystem::path& root_;
  const ConvexDecomposer& divide_;
  MeshImporter importer_;
  const std::map<std::string, KnownShapes>& known_;
  MeshTotal meshes_;  ///< of the objects so far
  YamlReport& report_;
  ResolvedCell out_;
  std::vector<std::vector<Pose>> X_WL_;  ///< per robot, per link
  std::vector<State> robot_states_, object_states_;
};

}  // namespace

ResolvedCell resolveCell(const CellDescription& cell, const ModelCache& models,
                         const std::filesystem::path& root, const ConvexDecomposer& divide,
                         const std::map<std::string, KnownShapes>& known, YamlReport& report) {
  return SceneResolver(cell, models, root, divide, known, report).resolve();
}

}  // namespace handover
