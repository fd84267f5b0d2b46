// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/robot_loader.hpp"

#include "core/model/joint_limits.hpp"
#include "core/model_io/file_fault.hpp"
#include "core/model_io/srdf_reader.hpp"
#include "core/model_io/urdf_reader.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>

namespace handover {
namespace {

constexpr int kMaxArmJoints = 8;
/// A request's speed is bounded so, too: motions below are slips of units, and take samples without
/// end. [rad/s or m/s]
constexpr double kLeastVelocity = 1e-3;
constexpr double kCupTilt = 0.5 * M_PI / 180;  // of a cup's axis off the approach axis [rad]

std::string sha256(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(),
                                                                        &EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  std::array<char, 65536> block{};
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0) {
    EVP_DigestUpdate(context.get(), block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &size);
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned i = 0; i < size; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 0x0F];
  }
  return hex;
}

/// Limits how fast speed and acceleration change, as an arm, a hand or the robot says.
template <typename Settings>
void limitChanges(const Settings& settings, Joint& joint) {
  joint.acceleration = settings.acceleration;
  joint.jerk = settings.jerk.value_or(kJerkPerAcceleration * settings.acceleration);
}

/// Puts URDF, SRDF and settings together; collects what does not fit.
class RobotAssembler {
 public:
  RobotAssembler(const RobotSettings& settings, RobotModel& model, const SrdfModel& srdf,
                 std::vector<int> limit_lines, std::vector<FileFault>& faults)
      : settings_(settings),
        model_(model),
        srdf_(srdf),
        limit_lines_(std::move(limit_lines)),
        faults_(faults) {}

  /// Arms only where the SRDF had no fault: without the right groups much else would seem wrong.
  void assemble(bool groups_known) {
    for (Joint& joint : model_.joints) {
      if (joint.type != JointType::kFixed) limitChanges(settings_, joint);
    }
    for (const HandSettings& hand : settings_.hands) addHand(hand);
    if (!groups_known) return;
    for (const ArmSettings& arm : settings_.arms) addArm(arm);
    checkDofsUsedOnce();
    spreadToMimics();
    for (const auto& [name, state] : srdf_.states) addState(name, state);
    model_.disabled_pairs = srdf_.disabled_pairs;
  }

 private:
  void fault(const std::string& key, const std::string& message) {
    const auto line = settings_.lines.find(key);
    faults_.push_back({settings_.settings_file, line == settings_.lines.end() ? 0 : line->second,
                       key + ": " + message});
  }

  LinkId linkOf(const std::string& key, const std::string& name) {
    const LinkId link = model_.findLink(name);
    if (!link.valid()) fault(key, "link '" + name + "' is not in the URDF");
    return link;
  }

  Joint& jointOf(DofId dof) { return model_.joints[model_.dof_joints[dof]]; }

  // ---- hands

  void addHand(const HandSettings& settings) {
    const std::string key = "hands." + settings.name;
    if (model_.findHand(settings.name).valid()) return fault(key, "is defined twice");
    Hand hand;
    hand.name = settings.name;
    if (settings.suction) {
      const SuctionSettings& suction = *settings.suction;
      hand.palm_link = linkOf(key + ".suction.cup_link", suction.cup_link);
      hand.suction = Suction{hand.palm_link, suction.axis, suction.radius, suction.engage_s};
      if (hand.palm_link.valid()) hand.links = {hand.palm_link};
      model_.hands.push_back(std::move(hand));
      return;
    }
    hand.palm_link = linkOf(key + ".palm_link", settings.palm_link);
    for (const std::string& name : settings.finger_links) {
      const LinkId link = linkOf(key + ".finger_links", name);
      if (link.valid() && isAmong(hand.finger_links, link)) {
        fault(key + ".finger_links", "link '" + name + "' is there twice");
      }
      hand.finger_links.push_back(link);
    }
    addHandDofs(key, settings, hand);
    for (const auto& names : settings.fingers) addFinger(key + ".fingers", names, hand);
    if (hand.palm_link.valid()) {
      hand.links = handLinks(hand);
      checkFingerLinks(key + ".finger_links", hand);
    }
    model_.hands.push_back(std::move(hand));
  }

  template <class Tag>
  static bool isAmong(const std::vector<Id<Tag>>& list, Id<Tag> value) {
    return std::find(list.begin(), list.end(), value) != list.end();
  }

  void checkFingerLinks(const std::string& key, const Hand& hand) {
    for (const LinkId link : hand.finger_links) {
      if (!link.valid() || isAmong(hand.links, link)) continue;
      fault(key, "link '" + model_.links[link].name + "' is no part of the hand");
    }
  }

  void addHandDofs(const std::string& key, const HandSettings& settings, Hand& hand) {
    for (const auto& [name, position] : settings.open) {
      const DofId dof = independentDof(key + ".open", name);
      if (dof.valid()) hand.dofs.push_back(dof);
      if (!settings.closed.contains(name))
        fault(key + ".closed", "joint '" + name + "' is missing");
    }
    std::sort(hand.dofs.begin(), hand.dofs.end());
    hand.open.setZero(static_cast<Eigen::Index>(hand.dofs.size()));
    hand.closed = hand.open;
    for (const auto& [name, position] : settings.open) {
      setPosture(key + ".open", name, position, hand, hand.open);
    }
    for (const auto& [name, position] : settings.closed) {
      if (!settings.open.contains(name)) {
        fault(key + ".closed", "joint '" + name + "' is not among those of open");
      } else {
        setPosture(key + ".closed", name, position, hand, hand.closed);
      }
    }
    for (const DofId dof : hand.dofs) {
      limitChanges(settings, jointOf(dof));
      checkVelocity(key + ".open", model_.dof_joints[dof]);
    }
  }

  void checkVelocity(const std::string& key, JointId index) {
    const Joint& joint = model_.joints[index];
    if (joint.velocity <= 0) {
      return fault(key, "joint '" + joint.name + "' has no velocity limit in the URDF");
    }
    if (joint.velocity >= kLeastVelocity) return;
    char figures[96];
    std::snprintf(figures, sizeof(figures), "has a velocity limit of %.3g %s, below %.3g",
                  joint.velocity, joint.type == JointType::kPrismatic ? "m/s" : "rad/s",
                  kLeastVelocity);
    faults_.push_back({(settings_.root / settings_.urdf).string(), limit_lines_.at(index),
                       "<joint> '" + joint.name + "' " + figures});
  }

  DofId independentDof(const std::string& key, const std::string& joint_name) {
    const JointId joint = model_.findJoint(joint_name);
    if (!joint.valid()) {
      fault(key, "joint '" + joint_name + "' is not in the URDF");
      return {};
    }
    const Joint& it = model_.joints[joint];
    if (it.type == JointType::kFixed || it.mimic) {
      fault(key, "joint '" + joint_name + "' " + (it.mimic ? "mimics another" : "is fixed"));
      return {};
    }
    return it.dof;
  }

  void setPosture(const std::string& key, const std::string& name, double position,
                  const Hand& hand, Eigen::VectorXd& posture) {
    const JointId joint = model_.findJoint(name);
    if (!joint.valid()) return;  // said already
    const Joint& it = model_.joints[joint];
    const auto at = std::find(hand.dofs.begin(), hand.dofs.end(), it.dof);
    if (it.mimic || at == hand.dofs.end()) return;
    if (!withinWrittenLimits(it, position)) {
      return fault(key,
                   "joint '" + name + "' is outside its limits: " + besideLimits(it, position));
    }
    posture[at - hand.dofs.begin()] = std::clamp(position, it.lower, it.upper);
  }

  void addFinger(const std::string& key, const std::vector<std::string>& names, Hand& hand) {
    if (names.empty()) return fault(key, "a finger has no joint");
    std::vector<DofId> finger;
    for (const std::string& name : names) {
      const DofId dof = independentDof(key, name);
      if (!dof.valid()) continue;
      if (std::find(hand.dofs.begin(), hand.dofs.end(), dof) == hand.dofs.end()) {
        fault(key, "joint '" + name + "' is not among those of open");
        continue;
      }
      const bool again =
          isAmong(finger, dof) ||
          std::any_of(hand.fingers.begin(), hand.fingers.end(),
                      [dof](const std::vector<DofId>& other) { return isAmong(other, dof); });
      if (again) fault(key, "joint '" + name + "' is there twice");
      finger.push_back(dof);
    }
    hand.fingers.push_back(std::move(finger));
  }

  /// The palm, what its fingers move and whatever hangs on these.
  std::vector<LinkId> handLinks(const Hand& hand) const {
    std::vector<bool> in_hand(model_.links.size(), false);
    for (const LinkId link : model_.linksMovedBy(hand.dofs)) in_hand[link] = true;
    in_hand[hand.palm_link] = true;
    std::vector<LinkId> links;
    for (const LinkId i : IdRange<LinkId>(model_.links.size())) {
      const JointId joint = model_.links[i].parent_joint;
      if (joint.valid() && in_hand[model_.joints[joint].parent_link]) {
        in_hand[i] = true;
      }
      if (in_hand[i]) links.push_back(i);
    }
    return links;
  }

  // ---- arms

  void addArm(const ArmSettings& settings) {
    const std::string key = "arms." + settings.name;
    if (model_.findArm(settings.name).valid()) return fault(key, "is defined twice");
    Arm arm;
    arm.name = settings.name;
    arm.tool_link = linkOf(key + ".tool_link", settings.tool_link);
    arm.p_AShoulder = settings.p_AShoulder;
    arm.hand = model_.findHand(settings.hand);
    if (!arm.hand.valid()) fault(key + ".hand", "hand '" + settings.hand + "' is not defined");
    if (settings.approach_axis.norm() < 1e-9) {
      fault(key + ".approach_axis", "is zero");
    } else {
      arm.approach_axis = settings.approach_axis.normalized();
    }
    const auto group = srdf_.groups.find(settings.name);
    if (group == srdf_.groups.end()) {
      return fault(key, "an arm is named as its group of the SRDF, which has " + groupNames());
    }
    if (!addArmJoints(key, settings, group->second, arm)) return;
    model_.arms.push_back(std::move(arm));
  }

  std::string groupNames() const {
    std::string names;
    for (const auto& [name, group] : srdf_.groups) names += (names.empty() ? "" : ", ") + name;
    return names.empty() ? "no groups" : names;
  }

  bool addArmJoints(const std::string& key, const ArmSettings& settings, const SrdfGroup& group,
                    Arm& arm) {
    const std::string at = "group '" + settings.name + "'";
    const auto count = group.joints.size();
    if (count == 0 || count > static_cast<std::size_t>(kMaxArmJoints)) {
      fault(key, at + " has " + std::to_string(count) + " movable joints, not 1 to " +
                     std::to_string(kMaxArmJoints));
      return false;
    }
    for (const JointId index : group.joints) {
      Joint& joint = model_.joints[static_cast<std::size_t>(index)];
      if (joint.mimic) {
        fault(key, at + " has the mimic joint '" + joint.name + "'");
        return false;
      }
      checkVelocity(key, index);
      limitChanges(settings, joint);
      arm.joints.push_back(index);
      arm.dofs.push_back(joint.dof);
    }
    arm.base_link = model_.joints[arm.joints.front()].parent_link;
    if (!arm.tool_link.valid()) return false;
    if (movableAbove(arm.tool_link, arm.base_link) != arm.joints) {
      fault(key + ".tool_link", "the joints of " + at +
                                    " are not those between its base and link '" +
                                    settings.tool_link + "'");
      return false;
    }
    if (!arm.hand.valid()) return true;
    const Hand& hand = model_.hands[arm.hand];
    const LinkId palm = hand.palm_link;
    if (hand.suction && palm.valid()) {
      checkCup(key, settings, *hand.suction, arm);
    } else if (palm.valid() && !isAmong(model_.linksMovedBy({arm.dofs.back()}), palm)) {
      fault(key + ".hand", "the palm of hand '" + settings.hand + "' does not hang on this arm");
    }
    return true;
  }

  /// The cup is no joint away from the tool link, and the tool comes along its axis.
  void checkCup(const std::string& key, const ArmSettings& settings, const Suction& cup,
                const Arm& arm) {
    if (movableAbove(cup.cup_link, arm.base_link) != arm.joints) {
      return fault(
          "hands." + settings.hand + ".suction.cup_link",
          "is not rigid with the tool link '" + settings.tool_link + "' of arm '" + arm.name + "'");
    }
    std::vector<Pose> X_BL;
    linkPoses(model_, Pose::Identity(), RobotVector::Zero(model_.dofs()), X_BL);
    const auto inBase = [&](LinkId link, const Eigen::Vector3d& axis) -> Eigen::Vector3d {
      return X_BL[link].linear() * axis;
    };
    const double cosine =
        inBase(arm.tool_link, arm.approach_axis).dot(inBase(cup.cup_link, cup.axis));
    if (cosine < std::cos(kCupTilt)) {
      fault(key + ".approach_axis",
            "is not along the axis of the suction cup '" + model_.links[cup.cup_link].name + "'");
    }
  }

  /// Movable joints between two links, base to tip; up to the root if `base` is not above `tip`.
  std::vector<JointId> movableAbove(LinkId tip, LinkId base) const {
    std::vector<JointId> joints;
    for (LinkId link = tip; link != base;) {
      const JointId joint = model_.links[link].parent_joint;
      if (!joint.valid()) break;
      const Joint& it = model_.joints[joint];
      if (it.type != JointType::kFixed) joints.push_back(joint);
      link = it.parent_link;
    }
    std::reverse(joints.begin(), joints.end());
    return joints;
  }

  void checkDofsUsedOnce() {
    std::set<DofId> used;
    const auto claim = [&](const std::string& key, const std::vector<DofId>& dofs) {
      for (const DofId dof : dofs) {
        if (used.insert(dof).second) continue;
        fault(key, "joint '" + jointOf(dof).name + "' belongs to another arm or hand already");
      }
    };
    for (const Arm& arm : model_.arms) claim("arms." + arm.name, arm.dofs);
    for (const Hand& hand : model_.hands) claim("hands." + hand.name, hand.dofs);
  }

  void spreadToMimics() {
    for (Joint& joint : model_.joints) {
      if (joint.mimic) {
        joint.acceleration = jointOf(joint.dof).acceleration * std::abs(joint.mimic_multiplier);
        joint.jerk = jointOf(joint.dof).jerk * std::abs(joint.mimic_multiplier);
      }
    }
  }

  void addState(const std::string& name, const std::map<JointId, double>& state) {
    RobotVector q(model_.dofs());
    for (const DofId dof : IdRange<DofId>(model_.dofs())) {
      const auto given = state.find(model_.dof_joints[dof]);
      const double position = given == state.end() ? 0.0 : given->second;
      q[dof.value()] = std::clamp(position, jointOf(dof).lower, jointOf(dof).upper);
    }
    model_.named_states.emplace(name, std::move(q));
  }

  const RobotSettings& settings_;
  RobotModel& model_;
  const SrdfModel& srdf_;
  std::vector<int> limit_lines_;
  std::vector<FileFault>& faults_;
};

}  // namespace

RobotModel loadRobot(const RobotSettings& settings, const ConvexDecomposer& divide) {
  std::vector<FileFault> faults;
  const std::filesystem::path urdf_file = settings.root / settings.urdf;
  UrdfModel urdf = readUrdf(urdf_file, urdf_file.string(), faults, divide);
  if (!faults.empty()) throw FileError(std::move(faults));  // names cannot be checked against it
  const std::filesystem::path srdf_file = settings.root / settings.srdf;
  const SrdfModel srdf = readSrdf(srdf_file, srdf_file.string(), urdf, faults);
  const bool groups_known = faults.empty();

  RobotModel model;
  model.name = settings.name;
  model.urdf_path = settings.urdf;
  model.srdf_path = settings.srdf;
  model.urdf_sha256 = sha256(urdf_file);
  model.yaml_path = settings.yaml;
  if (!settings.yaml.empty()) model.yaml_sha256 = sha256(settings.root / settings.yaml);
  model.links = std::move(urdf.links);
  model.joints = std::move(urdf.joints);
  model.dof_joints = std::move(urdf.dof_joints);
  RobotAssembler(settings, model, srdf, std::move(urdf.limit_lines), faults).assemble(groups_known);
  if (!faults.empty()) throw FileError(std::move(faults));
  model.content_hash = modelHash(model);
  return model;
}

}  // namespace handover
