// SPDX-License-Identifier: Apache-2.0
#include "view/plan_json.hpp"

#include "view/unreadable.hpp"

#include <nlohmann/json.hpp>

namespace handover::view {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "handover-plan/2";

PoseValue valueOf(const Json& pose) {
  return {pose.at("xyz").get<std::array<double, 3>>(),
          pose.at("quat_wxyz").get<std::array<double, 4>>()};
}

CompoundGeometry compoundOf(const Json& parts) {
  CompoundGeometry compound;
  for (const Json& part : parts) {
    compound.parts.push_back({valueOf(part.at("X_OS")), geometryOf(part.at("geometry"))});
  }
  return compound;
}

}  // namespace

Json parsePlanFile(const std::string& text) {
  Json file = Json::parse(text, nullptr, false);
  if (file.is_discarded()) throw Unreadable("/", "is no JSON");
  if (!file.is_object() || file.value("format", Json()) != kFormat) {
    throw Unreadable("/format", std::string("is not ") + kFormat);
  }
  return file;
}

Pose poseOf(const Json& pose) { return toPose(valueOf(pose)); }

Geometry geometryOf(const Json& geometry) {
  const auto type = geometry.at("type").get<std::string>();
  if (type == "box") return BoxGeometry{geometry.at("size").get<std::array<double, 3>>()};
  if (type == "sphere") return SphereGeometry{geometry.at("radius").get<double>()};
  if (type == "cylinder") {
    return CylinderGeometry{geometry.at("radius").get<double>(),
                            geometry.at("length").get<double>()};
  }
  if (type == "mesh") {
    return MeshGeometry{geometry.at("path").get<std::string>(),
                        geometry.at("scale").get<std::array<double, 3>>()};
  }
  if (type == "compound") return compoundOf(geometry.at("parts"));
  throw Unreadable("/scene/objects", "unknown geometry " + type);
}

}  // namespace handover::view
