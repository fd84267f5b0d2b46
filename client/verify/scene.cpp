// SPDX-License-Identifier: Apache-2.0
#include "verify/scene.hpp"

#include "verify/input_file.hpp"
#include "verify/sha256.hpp"
#include "verify/unreadable.hpp"

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

std::string robotPointer(std::size_t robot) { return "/plan/robots/" + std::to_string(robot); }

void requireLink(const Robot& robot, const std::string& link, const std::string& pointer) {
  if (robot.findLink(link) < 0) throw Unreadable(pointer, "unknown link \"" + link + "\"");
}

/// q_start and limits must name exactly the joints that are not fixed.
template <typename Map>
void requireJoints(const Robot& robot, const Map& values, const std::string& pointer) {
  for (const auto& [name, value] : values) {
    const int joint = robot.findJoint(name);
    if (joint < 0 || !robot.joints[static_cast<std::size_t>(joint)].movable()) {
      throw Unreadable(pointer + "/" + name, "the URDF has no such movable joint");
    }
  }
  for (const Joint& joint : robot.joints) {
    if (joint.movable() && !values.count(joint.name)) {
      throw Unreadable(pointer, "nothing for joint \"" + joint.name + "\"");
    }
  }
}

void checkNames(const Scene& scene) {
  const Plan& plan = scene.plan;
  for (std::size_t r = 0; r < plan.robots.size(); ++r) {
    requireJoints(scene.robots[r], plan.robots[r].q_start, robotPointer(r) + "/q_start");
    requireJoints(scene.robots[r], plan.robots[r].limits, robotPointer(r) + "/limits");
    for (const auto& [link, object] : plan.robots[r].resting) {
      requireLink(scene.robots[r], link, robotPointer(r) + "/resting");
    }
  }
  for (std::size_t o = 0; o < plan.objects.size(); ++o) {
    const auto& attached = plan.objects[o].attached_to;
    if (!attached) continue;
    const std::string at = "/plan/objects/" + std::to_string(o) + "/attached_to";
    const Robot& robot = scene.robots[static_cast<std::size_t>(plan.findRobot(attached->robot))];
    requireLink(robot, attached->link, at + "/link");
    for (const std::string& link : attached->touch_links) {
      requireLink(robot, link, at + "/touch_links");
    }
  }
  std::set<std::string> names;
  for (const PlanObject& object : plan.objects) names.insert(object.name);
  for (std::size_t r = 0; r < plan.robots.size(); ++r) {
    for (const Link& link : scene.robots[r].links) {
      names.insert(plan.robots[r].name + "/" + link.name);
    }
  }
  for (std::size_t s = 0; s < plan.stages.size(); ++s) {
    const PlanEvent& stage = plan.stages[s];
    const std::string at = "/plan/stages/" + std::to_string(s);
    const Robot& robot = scene.robots[static_cast<std::size_t>(plan.findRobot(stage.robot))];
    for (const std::string& joint : stage.joints) {
      if (robot.findJoint(joint) < 0) {
        throw Unreadable(at + "/joints", "unknown joint \"" + joint + "\"");
      }
    }
    for (const Hold& hold : stage.holding) {
      requireLink(scene.robots[static_cast<std::size_t>(plan.findRobot(hold.robot))], hold.link,
                  at + "/holding");
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

void loadBodies(Scene& scene, const fs::path& root) {
  MeshStore store;
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    const Robot& robot = scene.robots[r];
    const MeshSource source = [&](const MeshFile& mesh) {
      return store.get(resolveUrdfMesh(mesh.path, robot.urdf, root), mesh.scale);
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

Scene loadScene(Plan plan, const fs::path& root, Report& report) {
  Scene scene;
  scene.plan = std::move(plan);
  for (const PlanRobot& entry : scene.plan.robots) {
    const std::string hash = sha256(readFile(root / entry.urdf, kMaxUrdfBytes));
    if (hash == entry.urdf_sha256) continue;
    report.violations.push_back(
        {"",
         -1,
         0,
         "urdf_hash",
         entry.urdf + " has SHA-256 " + hash + ", the plan was made with " + entry.urdf_sha256,
         {entry.name}});
  }
  for (const PlanRobot& entry : scene.plan.robots) {
    scene.robots.push_back(readRobot(root / entry.urdf, root / entry.srdf));
    scene.kinematics.emplace_back(scene.robots.back(), entry.X_WB);
  }
  checkNames(scene);
  for (std::size_t r = 0; r < scene.robots.size(); ++r) {
    std::vector<double> q(scene.robots[r].joints.size(), 0.0);
    for (std::size_t j = 0; j < q.size(); ++j) {
      const Joint& joint = scene.robots[r].joints[j];
      if (joint.movable()) q[j] = scene.plan.robots[r].q_start.at(joint.name);
    }
    scene.q_start.push_back(std::move(q));
  }
  const auto party = [&](const std::string& robot, const std::string& tool_link) {
    const int index = scene.plan.findRobot(robot);
    return Party{index, scene.robots[static_cast<std::size_t>(index)].arm(tool_link)};
  };
  scene.giver = party(scene.plan.giver, scene.plan.giver_tool_link);
  scene.receiver = party(scene.plan.receiver, scene.plan.receiver_tool_link);
  scene.object = scene.plan.findObject(scene.plan.object);
  loadBodies(scene, root);
  return scene;
}

}  // namespace handover::verify
