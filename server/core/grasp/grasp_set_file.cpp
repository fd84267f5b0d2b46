// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grasp_set.hpp"
#include "core/model_io/file_text.hpp"

#include <handover/common/atomic_file.hpp>

#include <nlohmann/json.hpp>
#include <xxhash.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <span>
#include <stdexcept>

namespace handover {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "handover-grasp-set/2";
/// Raised whenever the same inputs would give another set.
constexpr std::uint64_t kGeneratorVersion = 2;
constexpr std::size_t kMaxGrasps = 10000;
constexpr std::uint64_t kMaxMib = 64;
constexpr std::size_t kMaxPerGrasp = 256;  // joints, contacts

/// Feeds values into a 64-bit xxhash, each with its size, so that no two inputs look alike.
class Hasher {
 public:
  Hasher() : state_(XXH64_createState(), &XXH64_freeState) { XXH64_reset(state_.get(), 0); }

  void add(double value) {
    const double plain = value + 0.0;  // one zero only
    XXH64_update(state_.get(), &plain, sizeof plain);
  }

  void add(std::uint64_t value) { XXH64_update(state_.get(), &value, sizeof value); }

  void add(int value) { add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value))); }

  void add(const std::string& text) {
    add(static_cast<std::uint64_t>(text.size()));
    XXH64_update(state_.get(), text.data(), text.size());
  }

  void add(const Pose& X) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) add(X(row, column));
    }
  }

  template <typename Derived>
  void add(const Eigen::MatrixBase<Derived>& vector) {
    add(static_cast<std::uint64_t>(vector.size()));
    for (Eigen::Index i = 0; i < vector.size(); ++i) add(static_cast<double>(vector[i]));
  }

  template <class Tag>
  void add(Id<Tag> id) {
    add(id.value());
  }

  template <typename Index>
  void add(const std::vector<Index>& list) {
    add(static_cast<std::uint64_t>(list.size()));
    for (const Index value : list) add(value);
  }

  void add(const std::vector<Shape>& shapes) {
    add(static_cast<std::uint64_t>(shapes.size()));
    for (const Shape& shape : shapes) add(shape);
  }

  /// Nothing where shapes are all there is.
  void add(const std::shared_ptr<const DividedBodies>& divided) {
    if (!divided) return;
    for (const DividedBody& body : *divided) add(body.hash);
  }

  void add(const Shape& shape) {
    add(shape.X_BS);
    add(static_cast<std::uint64_t>(shape.geometry.index()));
    if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) add(box->size);
    if (const auto* sphere = std::get_if<SphereShape>(&shape.geometry)) add(sphere->radius);
    if (const auto* cylinder = std::get_if<CylinderShape>(&shape.geometry)) {
      add(cylinder->radius);
      add(cylinder->length);
    }
    const auto* convex = std::get_if<ConvexShape>(&shape.geometry);
    if (convex == nullptr) return;
    add(static_cast<std::uint64_t>(convex->vertices.size()));
    for (const auto& vertex : convex->vertices) add(vertex);
    add(static_cast<std::uint64_t>(convex->triangles.size()));
    for (const auto& triangle : convex->triangles) {
      for (const int corner : triangle) add(corner);
    }
  }

  void add(const Joint& joint) {
    add(joint.name);
    add(static_cast<int>(joint.type));
    add(joint.X_PJ);
    add(joint.axis);
    for (const double v : {joint.lower, joint.upper, joint.mimic_multiplier, joint.mimic_offset})
      add(v);
    add(joint.dof);
    add(joint.mimic ? 1 : 0);
  }

  std::uint64_t value() const { return XXH64_digest(state_.get()); }

 private:
  std::unique_ptr<XXH64_state_t, decltype(&XXH64_freeState)> state_;
};

/// True for links at and beyond `root`.
std::vector<bool> linksBeyond(const RobotModel& model, LinkId root) {
  std::vector<bool> beyond(model.links.size(), false);
  beyond[root] = true;
  for (const Joint& joint : model.joints) {
    if (beyond[joint.parent_link]) beyond[joint.child_link] = true;
  }
  return beyond;
}

void addHand(Hasher& hash, const RobotModel& model, const Arm& arm) {
  const LinkId root = arm.joints.empty() ? LinkId(0) : model.joints[arm.joints.back()].child_link;
  const std::vector<bool> beyond = linksBeyond(model, root);
  for (const LinkId l : IdRange<LinkId>(model.links.size())) {
    if (!beyond[l]) continue;
    hash.add(model.links[l].name);
    hash.add(model.links[l].collision);
    hash.add(model.links[l].divided);
    if (l == root) continue;
    const Joint& joint = model.joints[model.links[l].parent_joint];
    hash.add(model.links[joint.parent_link].name);
    hash.add(joint);
  }
  for (const auto& [pair, reason] : model.disabled_pairs) {
    if (!beyond[pair.first] || !beyond[pair.second]) continue;
    hash.add(pair.first);
    hash.add(pair.second);
    hash.add(reason);
  }
  const Hand& hand = model.hands[arm.hand];
  hash.add(hand.name);
  hash.add(hand.palm_link);
  hash.add(hand.finger_links);
  hash.add(hand.dofs);
  for (const auto& finger : hand.fingers) hash.add(finger);
  hash.add(hand.open);
  hash.add(hand.closed);
  if (!hand.suction) return;
  hash.add(hand.suction->axis);
  hash.add(hand.suction->radius);
}

template <typename Vector>
json numbers(const Vector& vector) {
  json list = json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) list.push_back(vector[i] + 0.0);
  return list;
}

json toJson(const Grasp& grasp) {
  const PoseValue X_OT = toValue(grasp.X_OT);
  json contacts = json::array();
  for (const GraspContact& c : grasp.contacts) {
    contacts.push_back({{"link", c.link}, {"p_O", numbers(c.p_O)}, {"n_O", numbers(c.n_O)}});
  }
  return {{"X_OT", {{"xyz", X_OT.xyz}, {"quat_wxyz", X_OT.quat_wxyz}}},
          {"open", numbers(grasp.open)},
          {"closed", numbers(grasp.closed)},
          {"contacts", std::move(contacts)},
          {"quality", grasp.quality}};
}

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// Of the grasps as they are written.
std::string checksum(const json& grasps) {
  const std::string text = grasps.dump();
  return hex(XXH64(text.data(), text.size(), 0));
}

/// What is wrong, with the field's path; turned into an Error where the file's name is known.
class Malformed : public std::runtime_error {
 public:
  Malformed(const std::string& field, const std::string& fault)
      : std::runtime_error(field + ": " + fault) {}
};

const json& member(const json& object, const std::string& path, const char* name) {
  if (!object.is_object()) throw Malformed(path, "is not an object");
  const auto found = object.find(name);
  if (found == object.end()) throw Malformed(path.empty() ? name : path + "." + name, "is missing");
  return *found;
}

std::string text(const json& value, const std::string& path) {
  if (!value.is_string() || value.get_ref<const std::string&>().empty()) {
    throw Malformed(path, "is not a text");
  }
  return value.get<std::string>();
}

double number(const json& value, const std::string& path) {
  if (!value.is_number()) throw Malformed(path, "is not a number");
  const double plain = value.get<double>();
  if (!std::isfinite(plain)) throw Malformed(path, "is not finite");
  return plain;
}

const json& list(const json& value, const std::string& path, std::size_t least, std::size_t most) {
  if (!value.is_array()) throw Malformed(path, "is not a list");
  if (value.size() < least || value.size() > most) {
    throw Malformed(path, "has " + std::to_string(value.size()) + " entries, not " +
                              std::to_string(least) +
                              (least == most ? "" : " to " + std::to_string(most)));
  }
  return value;
}

Eigen::VectorXd vector(const json& value, const std::string& path, std::size_t least,
                       std::size_t most) {
  const json& entries = list(value, path, least, most);
  Eigen::VectorXd result(static_cast<Eigen::Index>(entries.size()));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    result[static_cast<Eigen::Index>(i)] = number(entries[i], path + "[" + std::to_string(i) + "]");
  }
  return result;
}

Pose pose(const json& value, const std::string& path) {
  const Eigen::VectorXd xyz = vector(member(value, path, "xyz"), path + ".xyz", 3, 3);
  const Eigen::VectorXd quat = vector(member(value, path, "quat_wxyz"), path + ".quat_wxyz", 4, 4);
  if (std::abs(quat.norm() - 1) > 1e-9)
    throw Malformed(path + ".quat_wxyz", "is not of unit length");
  return toPose({{xyz[0], xyz[1], xyz[2]}, {quat[0], quat[1], quat[2], quat[3]}});
}

GraspContact contact(const json& value, const std::string& path) {
  GraspContact result;
  result.link = text(member(value, path, "link"), path + ".link");
  result.p_O = vector(member(value, path, "p_O"), path + ".p_O", 3, 3);
  result.n_O = vector(member(value, path, "n_O"), path + ".n_O", 3, 3);
  if (std::abs(result.n_O.norm() - 1) > 1e-6)
    throw Malformed(path + ".n_O", "is not of unit length");
  return result;
}

Grasp grasp(const json& value, const std::string& path) {
  Grasp result;
  result.X_OT = pose(member(value, path, "X_OT"), path + ".X_OT");
  result.open = vector(member(value, path, "open"), path + ".open", 0, kMaxPerGrasp);
  const auto joints = static_cast<std::size_t>(result.open.size());
  // A cup has no joints and one contact.
  const std::size_t least = joints > 0 ? 2 : 1;
  const std::size_t most = joints > 0 ? kMaxPerGrasp : 1;
  result.closed = vector(member(value, path, "closed"), path + ".closed", joints, joints);
  const json& contacts = list(member(value, path, "contacts"), path + ".contacts", least, most);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    result.contacts.push_back(contact(contacts[i], path + ".contacts[" + std::to_string(i) + "]"));
  }
  result.quality = number(member(value, path, "quality"), path + ".quality");
  if (!(result.quality > 0)) throw Malformed(path + ".quality", "is not positive");
  return result;
}

GraspSet graspSet(const json& file, std::uint64_t expected_hash) {
  if (text(member(file, "", "format"), "format") != kFormat)
    throw Malformed("format", std::string("is not ") + kFormat);
  if (text(member(file, "", "hash"), "hash") != hex(expected_hash)) {
    throw Malformed("hash", "belongs to another object, hand or parameters");
  }
  GraspSet set;
  set.object = text(member(file, "", "object"), "object");
  set.robot = text(member(file, "", "robot"), "robot");
  set.hand = text(member(file, "", "hand"), "hand");
  const json& grasps = list(member(file, "", "grasps"), "grasps", 0, kMaxGrasps);
  if (grasps.empty()) set.none_because = text(member(file, "", "none_because"), "none_because");
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    const std::string path = "grasps[" + std::to_string(i) + "]";
    set.grasps.push_back(grasp(grasps[i], path));
    if (set.grasps[i].open.size() != set.grasps[0].open.size()) {
      throw Malformed(path + ".open", "has another number of joints than grasps[0]");
    }
    if (i > 0 && set.grasps[i].quality > set.grasps[i - 1].quality) {
      throw Malformed(path + ".quality", "is better than the one before");
    }
  }
  if (text(member(file, "", "checksum"), "checksum") != checksum(grasps)) {
    throw Malformed("checksum", "does not fit the grasps: the file is damaged");
  }
  return set;
}

}  // namespace

std::uint64_t graspSetHash(const SceneObject& object, const RobotModel& model, ArmId arm,
                           const GraspParams& params) {
  const Arm& a = model.arms.at(arm);
  Hasher hash;
  hash.add(std::string(kFormat));
  hash.add(kGeneratorVersion);
  hash.add(object.name);
  hash.add(object.shapes);
  hash.add(object.divided);
  hash.add(model.name);
  hash.add(model.links[a.tool_link].name);
  hash.add(a.approach_axis);
  if (a.hand.valid()) addHand(hash, model, a);
  hash.add(params.wanted);
  for (const double v :
       {params.surplus, params.palm_gap, params.min_spacing, params.min_angle, params.friction}) {
    hash.add(v);
  }
  hash.add(params.rolls);
  hash.add(params.seed);
  if (a.hand.valid() && model.hands[a.hand].suction) {
    hash.add(params.seal_bend);
    hash.add(params.holding);
  }
  return hash.value();
}

Result<void> writeGraspSet(const GraspSet& set, std::uint64_t hash,
                           const std::filesystem::path& file) {
  json grasps = json::array();
  for (const Grasp& g : set.grasps) grasps.push_back(toJson(g));
  const std::string sum = checksum(grasps);
  json whole = {{"format", kFormat},          {"hash", hex(hash)},  {"checksum", sum},
                {"object", set.object},       {"robot", set.robot}, {"hand", set.hand},
                {"grasps", std::move(grasps)}};
  if (set.grasps.empty()) whole["none_because"] = set.none_because;
  const std::string text = whole.dump() + "\n";
  return writeFileAtomically(file, std::as_bytes(std::span(text)));
}

Result<GraspSet> readGraspSet(const std::filesystem::path& file, std::uint64_t expected_hash) {
  const Result<std::string> content = readFileText(file, kMaxMib);
  if (!content) return {content.error().code, file.string() + ": " + content.error().detail};
  try {
    return graspSet(json::parse(*content), expected_hash);
  } catch (const json::exception& fault) {
    return {ErrorCode::kInvalidInput, file.string() + ": " + fault.what()};
  } catch (const Malformed& fault) {
    return {ErrorCode::kInvalidInput, file.string() + ": " + fault.what()};
  }
}

}  // namespace handover
