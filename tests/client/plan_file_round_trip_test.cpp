// SPDX-License-Identifier: Apache-2.0
// What goes into a plan file comes out of it: drawn answers, written by the client, read by the
// verifier, which shares no code with it.
#include "any_events.hpp"
#include "property.hpp"
#include "verify/plan_file.hpp"

#include <handover/client/plan_file.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <map>

namespace handover::client {
namespace {

bool same(const std::array<double, 3>& written, const Eigen::Vector3d& read) {
  return read == Eigen::Vector3d(written[0], written[1], written[2]);
}

bool same(const PoseValue& written, const verify::Pose& read) {
  // The reader keeps a rotation matrix, so only the position comes back to the bit.
  return same(written.xyz, read.translation()) &&
         (toPose(written).linear() - read.linear()).norm() < 1e-12;
}

bool same(const Geometry& written, const verify::Geometry& read) {
  if (written.index() != read.index()) return false;
  if (const auto* box = std::get_if<BoxGeometry>(&written)) {
    return same(box->size, std::get<verify::Box>(read).size);
  }
  if (const auto* sphere = std::get_if<SphereGeometry>(&written)) {
    return sphere->radius == std::get<verify::Sphere>(read).radius;
  }
  if (const auto* cylinder = std::get_if<CylinderGeometry>(&written)) {
    const auto& other = std::get<verify::Cylinder>(read);
    return cylinder->radius == other.radius && cylinder->length == other.length;
  }
  if (const auto* mesh = std::get_if<MeshGeometry>(&written)) {
    const auto& other = std::get<verify::MeshFile>(read);
    return mesh->path == other.path && same(mesh->scale, other.scale);
  }
  const auto& parts = std::get<CompoundGeometry>(written).parts;
  const auto& others = std::get<verify::Compound>(read).parts;
  return std::equal(parts.begin(), parts.end(), others.begin(), others.end(),
                    [](const GeometryPart& part, const verify::PlacedGeometry& other) {
                      return same(part.X_OS, other.X_BS) && same(part.geometry, other.geometry);
                    });
}

void compare(const RobotSnapshot& written, const verify::PlanRobot& read) {
  RC_ASSERT(read.name == written.name);
  RC_ASSERT(read.urdf == written.urdf);
  RC_ASSERT(read.urdf_sha256 == written.urdf_sha256);
  RC_ASSERT(read.srdf == written.srdf);
  RC_ASSERT(same(written.X_WB, read.X_WB));
  RC_ASSERT(read.q_start ==
            (std::map<std::string, double>{written.q_start.begin(), written.q_start.end()}));
  RC_ASSERT(read.limits.size() == written.limits.size());
  for (const auto& [joint, limits] : written.limits) {
    const verify::ClaimedLimits& other = read.limits.at(joint);
    RC_ASSERT(
        (limits == JointLimits{other.lower, other.upper, other.velocity, other.acceleration}));
  }
  RC_ASSERT(read.resting == written.resting);
}

void compare(const ObjectSnapshot& written, const verify::PlanObject& read) {
  RC_ASSERT(read.name == written.name);
  RC_ASSERT(same(written.geometry, read.geometry));
  RC_ASSERT(same(written.X_WO, read.X_WO));
  RC_ASSERT(read.attached_to.has_value() == written.attached_to.has_value());
  if (written.attached_to) {
    RC_ASSERT(read.attached_to->robot == written.attached_to->robot);
    RC_ASSERT(read.attached_to->link == written.attached_to->link);
    RC_ASSERT(same(written.attached_to->X_LO, read.attached_to->X_LO));
    RC_ASSERT(read.attached_to->touch_links == written.attached_to->touch_links);
  }
  RC_ASSERT(read.resting == written.resting);
}

void compare(const StageTrajectory& written, const verify::PlanEvent& read) {
  RC_ASSERT(read.index == static_cast<int>(written.index));
  RC_ASSERT(read.kind == toString(written.kind));
  RC_ASSERT(read.robot == written.robot);
  RC_ASSERT(read.joints == written.joints);
  RC_ASSERT(read.start == written.start);
  RC_ASSERT(read.t == written.t);
  RC_ASSERT(read.q == written.q);
  RC_ASSERT(read.qd == written.qd);
  RC_ASSERT(read.holding.size() == written.holding.size());
  for (std::size_t i = 0; i < written.holding.size(); ++i) {
    RC_ASSERT(read.holding[i].object == written.holding[i].object);
    RC_ASSERT(read.holding[i].robot == written.holding[i].robot);
    RC_ASSERT(read.holding[i].link == written.holding[i].link);
    RC_ASSERT(same(written.holding[i].X_LO, read.holding[i].X_LO));
  }
  RC_ASSERT(read.may_touch == written.may_touch);
}

void compare(const Solution& written, const verify::Plan& read) {
  RC_ASSERT(read.giver_arm == written.giver_arm);
  RC_ASSERT(read.receiver_arm == written.receiver_arm);
  RC_ASSERT(read.giver_tool_link == written.giver_tool_link);
  RC_ASSERT(read.receiver_tool_link == written.receiver_tool_link);
  RC_ASSERT(same(written.X_WO_handover, read.X_WO_handover));
  RC_ASSERT(same(written.X_OT_giver, read.X_OT_giver));
  RC_ASSERT(same(written.X_OT_receiver, read.X_OT_receiver));
  RC_ASSERT((written.dexterity == Dexterity{read.receiver_place, read.receiver_handover,
                                            read.giver_pick, read.giver_handover}));
}

void compare(const SceneSnapshot& written, const verify::Plan& read) {
  RC_ASSERT(read.cell == written.cell);
  RC_ASSERT(read.task == written.task);
  RC_ASSERT(read.object == written.object);
  RC_ASSERT(read.giver == written.giver);
  RC_ASSERT(read.receiver == written.receiver);
  RC_ASSERT(same(written.X_WO_start, read.X_WO_start));
  RC_ASSERT(same(written.X_WO_goal, read.X_WO_goal));
  RC_ASSERT(read.robots.size() == written.robots.size());
  for (std::size_t i = 0; i < read.robots.size(); ++i) compare(written.robots[i], read.robots[i]);
  RC_ASSERT(read.objects.size() == written.objects.size());
  for (std::size_t i = 0; i < read.objects.size(); ++i)
    compare(written.objects[i], read.objects[i]);
}

/// Seed and hash, which the verifier has no use for, and the rest of the file.
void compareUnread(const PlanFile& file, const std::vector<PlanEvent>& answer,
                   const nlohmann::json& json) {
  const auto& scene = std::get<SceneSnapshot>(answer[1].payload);
  RC_ASSERT(json["plan"]["seed"].get<std::uint64_t>() == scene.seed);
  RC_ASSERT(json["plan"]["scene_hash"] == scene.scene_hash);
  const auto& done = std::get<Done>(std::get<Outcome>(answer.back().payload));
  RC_ASSERT(json["complete"] == done.complete);
  RC_ASSERT(json["timing"]["scene_revision"].get<std::uint64_t>() ==
            std::get<Accepted>(answer[0].payload).scene_revision);
  RC_ASSERT(json["funnel"]["solutions"] == done.solution + 1);
  RC_ASSERT(json["funnel"]["giver_grasp"] == file.solution()->giver_grasp);
  RC_ASSERT(json["funnel"]["receiver_grasp"] == file.solution()->receiver_grasp);
}

TEST(PlanFile, IsReadBackAsItWasWrittenWhateverIsDrawn) {
  EXPECT_TRUE(test::holds("answers", 60, [] {
    const std::vector<PlanEvent> answer = test::anyAnswer();
    PlanFile file;
    for (const PlanEvent& stage : answer) file.add(stage);
    RC_ASSERT(file.complete());
    const std::string text = file.text();
    const verify::Plan plan = verify::parsePlan(text);
    compare(std::get<SceneSnapshot>(answer[1].payload), plan);
    compare(*file.solution(), plan);
    const auto trajectories = file.trajectories();
    RC_ASSERT(plan.stages.size() == trajectories.size());
    for (std::size_t i = 0; i < plan.stages.size(); ++i) {
      compare(*trajectories[i], plan.stages[i]);
    }
    compareUnread(file, answer, nlohmann::json::parse(text));
  }));
}

TEST(JsonLine, IsOneLineOfJsonWhateverIsDrawn) {
  EXPECT_TRUE(test::holds("stages", 200, [] {
    const PlanEvent stage = test::anyStage();
    const std::string line = jsonLine(stage);
    RC_ASSERT(line.find('\n') == std::string::npos);
    const auto json = nlohmann::json::parse(line);
    RC_ASSERT(json["type"] == payloadName(stage.payload));
    RC_ASSERT(json["sequence"] == stage.sequence);
    RC_ASSERT(json["request_id"] == stage.request_id.hex());
  }));
}

}  // namespace
}  // namespace handover::client
