// SPDX-License-Identifier: Apache-2.0
#include "verify/scene.hpp"

#include "verify/input_file.hpp"
#include "verify/sha256.hpp"
#include "verify/unreadable.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace handover::verify {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxUrdfBytes = 64u << 20;

/// Meshes by file and scale: hands share their finger's.
class MeshStore {
 public:
  std::vector<Mesh> get(const fs::path& file, const Eigen::Vector3d& scale) {
    const Key key{file.string(), {scale.x(), scale.y(), scale.z()}};
    const auto found = meshes_.find(key);
    if (found != meshes_.end()) return found->second;
    requireFile(file);
    return meshes_.emplace(key, readMesh(file, scale)).first->second;
  }

 private:
  using Key = std::pair<std::string, std::array<double, 3>>;
  std::map<Key, std::vector<Mesh>> meshes_;
};

std::string robotPointer(std::size_t robot) { return "/scene/robots/" + std::to_string(robot); }

void requireLink(const Robot& robot, const std::string& link, const std::string& pointer) {
  if (robot.findLink(link) < 0) throw Unreadable(pointer, "unknown link \"" + link + "\"");
}

/// q_start must name exactly the joints that are not fixed; limits may leave out those that follow
/// another.
template <typename Map>
void requireJoints(const Robot& robot, const Map& values, bool followers,
                   const std::string& pointer) {
  for (const auto& [name, value] : values) {
    const int joint = robot.findJoint(name);
    if (joint < 0 || !robot.joints[static_cast<std::size_t>(joint)].movable()) {
      throw Unreadable(pointer + "/" + name, "the URDF has no such movable joint");
    }
  }
  for (const Joint& joint : robot.joints) {
    if ((followers ? joint.movable() : joint.independent()) && !values.count(joint.name)) {
      throw Unreadable(pointer, "nothing for joint \"" + joint.name + "\"");
    }
  }
}

const Robot& robotNamed(const Scene& scene, const std::string& name) {
  return scene.robot(scene.plan.findRobot(name));
}

void checkSceneNames(const Scene& scene) {
  const Plan& plan = scene.plan;
  for (std::size_t r = 0; r < plan.robots.size(); ++r) {
    requireJoints(scene.robots[r], plan.robots[r].q_start, true, robotPointer(r) + "/q_start");
    requireJoints(scene.robots[r], plan.robots[r].limits, false, robotPointer(r) + "/limits");
    for (const auto& [link, object] : plan.robots[r].resting) {
      requireLink(scene.robots[r], link, robotPointer(r) + "/resting");
    }
  }
  for (std::size_t o = 0; o < plan.objects.size(); ++o) {
    const auto& attached = plan.objects[o].attached_to;
    if (!attached) continue;
    const std::string at = "/scene/objects/" + std::to_string(o) + "/attached_to";
    const Robot& robot = robotNamed(scene, attached->robot);
    requireLink(robot, attached->link, at + "/link");
    for (const std::string& link : attached->touch_links) {
      requireLink(robot, link, at + "/touch_links");
    }
  }
}

void checkHolderNames(const Scene& scene) {
  for (std::size_t k = 0; k < scene.plan.holders.size(); ++k) {
    const PlanHolder& holder = scene.plan.holders[k];
    const Robot& robot = robotNamed(scene, holder.robot);
    const std::string at = "/plan/holders/" + std::to_string(k);
    requireLink(robot, holder.tool_link, at + "/tool_link");
    if (holder.suction) {
      requireLink(robot, holder.cup_link, at + "/hand/cup_link");
      continue;
    }
    requireLink(robot, holder.palm, at + "/hand/palm");
    for (const std::string& link : holder.fingers) requireLink(robot, link, at + "/hand/fingers");
  }
}

/// Of everything that a contact can be claimed of: links without geometry are named, too.
std::set<std::string> bodyNames(const Scene& scene) {
  std::set<std::string> names;
  for (const PlanObject& object : scene.plan.objects) names.insert(object.name);
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    for (const Link& link : scene.robots[r].links) {
      names.insert(scene.plan.robots[r].name + "/" + link.name);
    }
  }
  return names;
}

void checkStageNames(const Scene& scene) {
  const Plan& plan = scene.plan;
  const std::set<std::string> names = bodyNames(scene);
  for (std::size_t s = 0; s < plan.stages.size(); ++s) {
    const PlanStage& stage = plan.stages[s];
    const std::string at = "/plan/stages/" + std::to_string(s);
    const Robot& robot = robotNamed(scene, stage.robot);
    for (const std::string& joint : stage.joints) {
      if (robot.findJoint(joint) < 0) {
        throw Unreadable(at + "/joints", "unknown joint \"" + joint + "\"");
      }
    }
    for (const Hold& hold : stage.holding) {
      requireLink(robotNamed(scene, hold.robot), hold.link, at + "/holding");
    }
    for (const auto& [a, b] : stage.may_touch) {
      for (const std::string& name : {a, b}) {
        if (!names.count(name)) {
          throw Unreadable(at + "/may_touch", "unknown body \"" + name + "\"");
        }
      }
    }
  }
}

Holder lookUpHolder(const Scene& scene, const PlanHolder& entry) {
  Holder holder;
  holder.robot = scene.plan.findRobot(entry.robot);
  const Robot& robot = scene.robot(holder.robot);
  holder.tool_link = robot.findLink(entry.tool_link);
  const std::vector<int> above = robot.jointsAbove(holder.tool_link);
  for (const Group& group : robot.groups) {
    if (group.name != entry.arm) continue;
    holder.group_known = true;
    for (const int j : group.joints) {
      if (std::find(above.begin(), above.end(), j) != above.end()) holder.arm_joints.push_back(j);
    }
  }
  const int base = robot.rigidGroups()[static_cast<std::size_t>(holder.tool_link)];
  for (const int link : robot.subtree(base)) {
    const int joint = robot.links[static_cast<std::size_t>(link)].parent_joint;
    if (link != base && robot.joints[static_cast<std::size_t>(joint)].independent()) {
      holder.gripper_joints.push_back(joint);
    }
  }
  if (entry.suction) {
    holder.hand_links = {robot.findLink(entry.cup_link)};
  } else {
    for (const std::string& link : entry.fingers) {
      holder.finger_links.push_back(robot.findLink(link));
    }
    holder.hand_links = holder.finger_links;
    holder.hand_links.push_back(robot.findLink(entry.palm));
  }
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    if (body.robot == holder.robot && std::find(holder.hand_links.begin(), holder.hand_links.end(),
                                                body.link) != holder.hand_links.end()) {
      holder.hand_bodies.push_back(static_cast<int>(b));
    }
  }
  return holder;
}

void checkHash(const std::string& file, const std::string& claimed, const fs::path& root,
               const std::string& robot, Report& report) {
  const std::string hash = sha256(readFile(root / file, kMaxUrdfBytes));
  if (hash == claimed) return;
  report.add({-1,
              0,
              "hash",
              file + " has SHA-256 " + hash + ", the plan was made with " + claimed,
              {robot}});
}

void loadBodies(Scene& scene, const fs::path& root) {
  MeshStore store;
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    const Robot& robot = scene.robots[r];
    const Packages& packages = scene.settings[r].packages;
    const MeshSource source = [&](const MeshFile& mesh) {
      return store.get(resolveUrdfMesh(mesh.path, robot.urdf, root, packages), mesh.scale);
    };
    for (std::size_t l = 0; l < robot.links.size(); ++l) {
      if (robot.links[l].collision.empty()) continue;
      scene.bodies.push_back({scene.plan.robots[r].name + "/" + robot.links[l].name,
                              static_cast<int>(r), static_cast<int>(l), -1,
                              Body(robot.links[l].collision, source)});
    }
  }
  const MeshSource source = [&](const MeshFile& mesh) {
    return store.get(root / mesh.path, mesh.scale);
  };
  for (std::size_t o = 0; o < scene.plan.objects.size(); ++o) {
    const PlanObject& object = scene.plan.objects[o];
    if (static_cast<int>(o) == scene.object) {
      scene.object_body = static_cast<int>(scene.bodies.size());
    }
    scene.bodies.push_back({object.name, -1, -1, static_cast<int>(o),
                            Body({{Pose::Identity(), object.geometry}}, source)});
  }
}

}  // namespace

std::string Scene::stageName(int s) const {
  const PlanStage& entry = stage(s);
  return entry.robot + " " + planHolder(entry.holder).arm + " " + entry.action;
}

Scene loadScene(Plan plan, const fs::path& root, Report& report) {
  Scene scene;
  scene.plan = std::move(plan);
  for (const PlanRobot& entry : scene.plan.robots) {
    checkHash(entry.urdf, entry.urdf_sha256, root, entry.name, report);
    checkHash(entry.yaml, entry.yaml_sha256, root, entry.name, report);
  }
  for (const PlanRobot& entry : scene.plan.robots) {
    scene.robots.push_back(readRobot(root / entry.urdf, root / entry.srdf));
    scene.settings.push_back(readRobotSettings(root / entry.yaml, scene.robots.back()));
    scene.kinematics.emplace_back(scene.robots.back(), entry.X_WB);
  }
  checkSceneNames(scene);
  checkHolderNames(scene);
  checkStageNames(scene);
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    std::vector<double> q(scene.robots[r].joints.size(), 0.0);
    for (std::size_t j = 0; j < q.size(); ++j) {
      const Joint& joint = scene.robots[r].joints[j];
      if (joint.movable()) q[j] = scene.plan.robots[r].q_start.at(joint.name);
    }
    scene.q_start.push_back(std::move(q));
  }
  scene.object = scene.plan.findObject(scene.plan.object);
  loadBodies(scene, root);
  for (const PlanHolder& entry : scene.plan.holders) {
    scene.holders.push_back(lookUpHolder(scene, entry));
  }
  for (const PlanStage& stage : scene.plan.stages) {
    scene.stage_robot.push_back(scene.plan.findRobot(stage.robot));
    std::vector<int> joints;
    for (const std::string& name : stage.joints) {
      joints.push_back(scene.robot(scene.stage_robot.back()).findJoint(name));
    }
    scene.stage_joints.push_back(std::move(joints));
  }
  return scene;
}

}  // namespace handover::verify
