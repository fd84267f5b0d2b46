// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/srdf_reader.hpp"

#include "core/model/joint_limits.hpp"
#include "core/model_io/xml_reader.hpp"

#include <algorithm>
#include <set>

namespace handover {
namespace {

using tinyxml2::XMLElement;

/// Groups may hold groups, each read by recursion.
constexpr std::size_t kMaxGroups = 256, kMaxChains = 1024;

class SrdfReader {
 public:
  SrdfReader(const std::string& shown_file, const UrdfModel& urdf, std::vector<FileFault>& faults)
      : urdf_(urdf), faults_(shown_file, faults) {
    for (std::size_t i = 0; i < urdf.links.size(); ++i) {
      links_.emplace(urdf.links[i].name, LinkId(i));
    }
    for (std::size_t i = 0; i < urdf.joints.size(); ++i) {
      joints_.emplace(urdf.joints[i].name, JointId(i));
    }
  }

  SrdfModel read(const std::filesystem::path& file) {
    tinyxml2::XMLDocument document;
    const XMLElement* robot = parseXml(file, document, faults_);
    if (robot == nullptr) return {};
    if (const std::string name = requiredText(*robot, "name", faults_);
        !name.empty() && name != urdf_.name) {
      faults_.add(*robot, "robot '" + name + "' is called '" + urdf_.name + "' in the URDF");
    }
    checkChildren(*robot, {},
                  {"group", "group_state", "end_effector", "virtual_joint", "passive_joint",
                   "disable_collisions", "enable_collisions", "disable_default_collisions",
                   "joint_property", "link_sphere_approximation"},
                  faults_);
    if (tooMany(*robot)) return {};
    collectGroups(*robot);
    for (const auto& [name, element] : group_elements_) {
      const std::set<JointId>& joints = jointsOf(name, *element);
      model_.groups.emplace(name, SrdfGroup{element->GetLineNum(), {joints.begin(), joints.end()}});
    }
    forEach(*robot, "end_effector", [this](const XMLElement& e) { readEndEffector(e); });
    forEach(*robot, "group_state", [this](const XMLElement& e) { readState(e); });
    forEach(*robot, "passive_joint",
            [this](const XMLElement& e) { named(joints_, e, "name", "joint"); });
    forEach(*robot, "virtual_joint",
            [this](const XMLElement& e) { named(links_, e, "child_link", "link"); });
    forEach(*robot, "disable_collisions", [this](const XMLElement& e) { readDisabled(e); });
    return std::move(model_);
  }

 private:
  bool tooMany(const XMLElement& robot) {
    std::size_t groups = 0, chains = 0;
    forEach(robot, "group", [&](const XMLElement& e) {
      ++groups;
      forEach(e, "chain", [&chains](const XMLElement&) { ++chains; });
    });
    if (groups <= kMaxGroups && chains <= kMaxChains) return false;
    faults_.add(robot, "has " + std::to_string(groups) + " groups with " + std::to_string(chains) +
                           " chains, more than " + std::to_string(kMaxGroups) + " with " +
                           std::to_string(kMaxChains));
    return true;
  }

  void collectGroups(const XMLElement& robot) {
    forEach(robot, "group", [this](const XMLElement& e) {
      const std::string name = requiredText(e, "name", faults_);
      if (name.empty()) return;
      if (!group_elements_.emplace(name, &e).second) {
        faults_.add(e, described(e) + " is defined twice");
      }
    });
  }

  /// The joint or link that an attribute names; told and none if it is not known.
  template <class Tag>
  Id<Tag> named(const std::map<std::string, Id<Tag>>& known, const XMLElement& at,
                const char* attribute, const char* what) {
    const std::string name = requiredText(at, attribute, faults_);
    if (name.empty()) return {};
    const auto found = known.find(name);
    if (found != known.end()) return found->second;
    faults_.add(at,
                std::string("<") + at.Name() + ">: " + what + " '" + name + "' is not in the URDF");
    return {};
  }

  /// The movable joints of a group's links, joints, chains and subgroups. Each group is read once.
  const std::set<JointId>& jointsOf(const std::string& name, const XMLElement& group) {
    const auto [entry, fresh] = group_joints_.try_emplace(name);
    if (!fresh) return entry->second;
    checkChildren(group, {}, {"joint", "link", "chain", "group"}, faults_);
    open_groups_.insert(name);
    std::set<JointId> joints;
    forEach(group, "joint",
            [&](const XMLElement& e) { addMovable(named(joints_, e, "name", "joint"), joints); });
    forEach(group, "link", [&](const XMLElement& e) {
      const LinkId link = named(links_, e, "name", "link");
      if (link.valid()) addMovable(urdf_.links[link].parent_joint, joints);
    });
    forEach(group, "chain", [&](const XMLElement& e) { addChain(e, joints); });
    forEach(group, "group", [&](const XMLElement& e) { addSubgroup(e, joints); });
    open_groups_.erase(name);
    entry->second = std::move(joints);
    return entry->second;
  }

  void addMovable(JointId joint, std::set<JointId>& joints) const {
    if (!joint.valid()) return;
    if (urdf_.joints[joint].type != JointType::kFixed) joints.insert(joint);
  }

  void addChain(const XMLElement& chain, std::set<JointId>& joints) {
    const LinkId base = named(links_, chain, "base_link", "link");
    const LinkId tip = named(links_, chain, "tip_link", "link");
    if (!base.valid() || !tip.valid()) return;
    std::set<JointId> found;
    LinkId link = tip;
    while (link != base) {
      const JointId joint = urdf_.links[link].parent_joint;
      if (!joint.valid()) {
        faults_.add(chain, "<chain>: no joints lead from '" + text(chain, "base_link") + "' to '" +
                               text(chain, "tip_link") + "'");
        return;
      }
      addMovable(joint, found);
      link = urdf_.joints[joint].parent_link;
    }
    joints.insert(found.begin(), found.end());
  }

  static std::string text(const XMLElement& element, const char* attribute) {
    const char* value = element.Attribute(attribute);
    return value == nullptr ? "" : value;
  }

  void addSubgroup(const XMLElement& element, std::set<JointId>& joints) {
    const std::string name = requiredText(element, "name", faults_);
    if (name.empty()) return;
    const auto found = group_elements_.find(name);
    if (found == group_elements_.end()) {
      return faults_.add(element, "<group>: group '" + name + "' is not defined");
    }
    if (open_groups_.contains(name)) {
      return faults_.add(element, "<group>: group '" + name + "' contains itself");
    }
    const std::set<JointId>& inner = jointsOf(name, *found->second);
    joints.insert(inner.begin(), inner.end());
  }

  void checkGroup(const XMLElement& element, const char* attribute) {
    const std::string group = requiredText(element, attribute, faults_);
    if (!group.empty() && !group_elements_.contains(group)) {
      faults_.add(element, described(element) + ": group '" + group + "' is not defined");
    }
  }

  void readEndEffector(const XMLElement& element) {
    const std::string name = requiredText(element, "name", faults_);
    if (!name.empty() && !end_effectors_.insert(name).second) {
      faults_.add(element, described(element) + " is defined twice");
    }
    checkGroup(element, "group");
    named(links_, element, "parent_link", "link");
    if (element.Attribute("parent_group") != nullptr) checkGroup(element, "parent_group");
  }

  void readState(const XMLElement& element) {
    const std::string name = requiredText(element, "name", faults_);
    checkGroup(element, "group");
    checkChildren(element, {}, {"joint"}, faults_);
    auto& state = model_.states[name];
    forEach(element, "joint", [&](const XMLElement& e) {
      const JointId joint = named(joints_, e, "name", "joint");
      const auto value = requiredNumber(e, "value", faults_);
      if (!joint.valid() || !value) return;
      const Joint& it = urdf_.joints[joint];
      if (it.type == JointType::kFixed) {
        return faults_.add(e, "<group_state> '" + name + "': joint '" + it.name + "' is fixed");
      }
      if (!withinWrittenLimits(it, *value)) {
        faults_.add(e, "<group_state> '" + name + "': joint '" + it.name +
                           "' is outside its limits: " + besideLimits(it, *value));
      }
      checkMembership(element, e, joint);
      if (const auto [known, added] = state.emplace(joint, *value);
          !added && known->second != *value) {
        faults_.add(e, "<group_state> '" + name + "': joint '" + it.name + "' has two values");
      }
    });
  }

  void checkMembership(const XMLElement& state, const XMLElement& at, JointId joint) {
    const std::string group = text(state, "group");
    const auto known = group_joints_.find(group);
    if (known == group_joints_.end() || known->second.contains(joint)) return;
    faults_.add(at, described(state) + ": joint '" + urdf_.joints[joint].name +
                        "' is not in group '" + group + "'");
  }

  void readDisabled(const XMLElement& element) {
    const LinkId a = named(links_, element, "link1", "link"),
                 b = named(links_, element, "link2", "link");
    if (!a.valid() || !b.valid()) return;
    if (a == b) return faults_.add(element, "<disable_collisions>: a link with itself");
    const std::string reason = requiredText(element, "reason", faults_);
    static constexpr std::string_view kReasons[] = {"Adjacent", "Always", "Never", "Default",
                                                    "User"};
    if (!reason.empty() &&
        std::find(std::begin(kReasons), std::end(kReasons), reason) == std::end(kReasons)) {
      faults_.add(element, "<disable_collisions>: unknown reason '" + reason +
                               "': Adjacent, Always, Never, Default or User");
    }
    const auto [known, added] =
        model_.disabled_pairs.emplace(std::pair(std::min(a, b), std::max(a, b)), reason);
    if (!added && known->second != reason) {
      faults_.add(element, "<disable_collisions>: '" + text(element, "link1") + "' and '" +
                               text(element, "link2") + "' have two reasons");
    }
  }

  const UrdfModel& urdf_;
  XmlFaults faults_;
  std::map<std::string, LinkId> links_;
  std::map<std::string, JointId> joints_;
  std::map<std::string, const XMLElement*> group_elements_;
  std::map<std::string, std::set<JointId>> group_joints_;
  std::set<std::string> end_effectors_;
  std::set<std::string> open_groups_;  ///< being read: a group found again in here contains itself
  SrdfModel model_;
};

}  // namespace

SrdfModel readSrdf(const std::filesystem::path& file, const std::string& shown_file,
                   const UrdfModel& urdf, std::vector<FileFault>& faults) {
  return SrdfReader(shown_file, urdf, faults).read(file);
}

}  // namespace handover
