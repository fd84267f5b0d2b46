// SPDX-License-Identifier: Apache-2.0
// Arms that are mirror images: found by their joints, one map for both.
#include "core/collision/arm_self_collision.hpp"
#include "core/reachability/arm_mirror.hpp"
#include "core/reachability/reachability_map.hpp"
#include "settings/cell_file.hpp"
#include "settings/roots.hpp"
#include "support/kdl_robot.hpp"
#include "support/temporary_folder.hpp"

#include <handover/common/random.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <deque>
#include <map>
#include <memory>

namespace handover::test {
namespace {

using ::testing::HasSubstr;

RobotModel shipped(const std::string& name) {
  const auto root = findRoot();
  return loadRobot(readRobotSettings(robotFile(name, root), root));
}

/// A configuration within limits.
ArmVector drawWithin(const ArmKinematics& arm, SeededRandom& random) {
  ArmVector q(arm.dofs());
  for (int i = 0; i < arm.dofs(); ++i) q[i] = random.uniform(arm.lower()[i], arm.upper()[i]);
  return q;
}

class ShippedRobot : public ::testing::TestWithParam<const char*> {
 protected:
  ShippedRobot() : model_(shipped(GetParam())), q_(RobotVector::Zero(model_.dofs())) {}

  /// In the robot's root frame, by another library: the tool's position and approach direction.
  std::pair<Eigen::Vector3d, Eigen::Vector3d> toolByKdl(std::size_t arm_index,
                                                        const ArmVector& q) const {
    const Arm& arm = model_.arms[arm_index];
    std::map<std::string, double> positions;
    for (const JointId joint : model_.dof_joints) positions[model_.joints[joint].name] = 0;
    for (std::size_t i = 0; i < arm.joints.size(); ++i) {
      positions[model_.joints[arm.joints[i]].name] = q[static_cast<Eigen::Index>(i)];
    }
    static const auto root = findRoot();
    const handover::testing::KdlRobot robot(root / "robots" / GetParam() /
                                            (std::string(GetParam()) + ".urdf"));
    const KDL::Frame tool = robot.pose(model_.links[arm.tool_link].name, positions);
    const Eigen::Vector3d& axis = arm.approach_axis;
    const KDL::Vector approach = tool.M * KDL::Vector(axis.x(), axis.y(), axis.z());
    return {{tool.p.x(), tool.p.y(), tool.p.z()}, {approach.x(), approach.y(), approach.z()}};
  }

  RobotModel model_;
  RobotVector q_;
};

TEST_P(ShippedRobot, HasArmsWhoseImagesAgreeWithAnotherLibrary) {
  const auto mirror = findArmMirror(model_, ArmId(0), ArmId(1), q_);
  ASSERT_TRUE(mirror.has_value()) << mirror.error().detail;
  EXPECT_EQ(mirror->S_ToFrom.determinant(), -1);
  const ArmKinematics from(model_, ArmId(0)), to(model_, ArmId(1));
  const Eigen::Vector3d flip(1, -1, 1);  // the plane y = 0 of the root
  SeededRandom random(11);
  for (int n = 0; n < 50; ++n) {
    const ArmVector q = drawWithin(from, random), image = mirror->image(q);
    EXPECT_TRUE(to.withinLimits(image, 1e-6));
    const auto [p, approach] = toolByKdl(0, q);
    const auto [p_image, approach_image] = toolByKdl(1, image);
    EXPECT_LT((p.cwiseProduct(flip) - p_image).norm(), 1e-6);
    EXPECT_LT((approach.cwiseProduct(flip) - approach_image).norm(), 1e-6);
    // And in the arms' own frames, where voxels are counted.
    EXPECT_LT((mirror->S_ToFrom * from.toolPose(q).translation() - to.toolPose(image).translation())
                  .norm(),
              1e-6);
    EXPECT_NEAR(from.manipulability(q), to.manipulability(image), 1e-9);
  }
}

TEST_P(ShippedRobot, IsJudgedByItsJointsNotByItsNames) {
  RobotModel model = model_;
  std::swap(model.arms[0].name, model.arms[1].name);
  for (Joint& joint : model.joints) joint.name = "j" + std::to_string(joint.child_link.value());
  EXPECT_TRUE(findArmMirror(model, ArmId(0), ArmId(1), q_).has_value());
}

TEST_P(ShippedRobot, IsNoMirrorImageAfterAnyChangeThatTheMapUses) {
  const auto complaint = [&](auto change) {
    RobotModel model = model_;
    const Arm& arm = model.arms[1];
    change(model, model.joints[arm.joints[3]], model.arms[1]);
    const auto mirror = findArmMirror(model, ArmId(0), ArmId(1), q_);
    return mirror ? std::string() : mirror.error().detail;
  };
  const std::string name = model_.joints[model_.arms[1].joints[3]].name;
  EXPECT_EQ(complaint([](RobotModel&, Joint&, Arm&) {}), "");
  EXPECT_EQ(complaint([](RobotModel&, Joint& joint, Arm&) { joint.velocity = 9; }), "");
  for (const std::string& detail :
       {complaint([](RobotModel&, Joint&joint, Arm&) { joint.upper += 1e-5; }),
        complaint([](RobotModel&, Joint&joint, Arm&) { joint.lower -= 1e-5; })}) {
    EXPECT_THAT(detail, HasSubstr("limits"));
    EXPECT_THAT(detail, HasSubstr(name));
  }
  EXPECT_THAT(complaint([](RobotModel&, Joint& joint, Arm&) {
                joint.X_PJ.translation() += Eigen::Vector3d(1e-5, 1e-5, 1e-5);
              }),
              HasSubstr("axes"));
  EXPECT_THAT(
      complaint([](RobotModel&, Joint& joint, Arm&) { joint.type = JointType::kPrismatic; }),
      HasSubstr(name));
  EXPECT_THAT(complaint([](RobotModel&, Joint&, Arm& arm) { arm.approach_axis *= -1; }),
              HasSubstr("approach"));
  EXPECT_THAT(complaint([](RobotModel& model, Joint&, Arm& arm) {
                const JointId joint = model.links[arm.tool_link].parent_joint;
                model.joints[joint].X_PJ.translation().x() += 1e-5;
              }),
              HasSubstr("tool"));
}

/// Both maps of a robot, self-collisions as the programs test them.
struct Maps {
  explicit Maps(const RobotModel& model) {
    const RobotVector q = RobotVector::Zero(model.dofs());
    const TemporaryFolder folder;
    std::deque<ArmSelfCollision> tests;
    std::vector<ReachabilityMap::SelfCollision> touch;
    std::vector<std::filesystem::path> files;
    for (int arm = 0; arm < 2; ++arm) {
      ArmSelfCollision& test = tests.emplace_back(model, ArmId(arm), q);
      touch.emplace_back([&test](const ArmVector& at) { return test.touches(at); });
      files.push_back(folder / std::to_string(arm));
    }
    const auto built = ReachabilityMap::build(model, q, params, touch, files, {}, Deadline());
    if (!built) throw std::runtime_error(built.error().detail);
    reports = *built;
    for (int arm = 0; arm < 2; ++arm) {
      const auto map =
          ReachabilityMap::open(files[arm], ReachabilityMap::hash(model, ArmId(arm), q, params));
      if (!map) throw std::runtime_error(map.error().detail);
      maps.push_back(*map);
    }
  }

  ReachabilityParams params{.samples = 60'000};
  std::vector<MapReport> reports;
  std::vector<std::shared_ptr<const ReachabilityMap>> maps;
};

/// Made once for all tests of a robot.
const Maps& mapsOf(const std::string& robot, const RobotModel& model) {
  static std::map<std::string, Maps> made;
  return made.try_emplace(robot, model).first->second;
}

class ShippedMaps : public ShippedRobot {
 protected:
  ShippedMaps()
      : made_(mapsOf(GetParam(), model_)),
        params_(made_.params),
        reports_(made_.reports),
        maps_(made_.maps) {
    std::vector<Pose> X_BL;
    linkPoses(model_, Pose::Identity(), q_, X_BL);
    for (const Arm& arm : model_.arms) {
      X_BA_.push_back(X_BL[arm.base_link]);
    }
  }

  /// Visits the centre of every cell about A's origin.
  template <typename Visit>
  void forEachCentre(const Visit& visit) const {
    for (int i = -30; i < 30; ++i) {
      for (int j = -30; j < 30; ++j) {
        for (int k = -30; k < 30; ++k)
          visit(params_.voxel * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5));
      }
    }
  }

  /// The paper's R of an arm at a point of the robot's root frame.
  double entry(std::size_t arm, const Eigen::Vector3d& p_B) const {
    return (*maps_[arm])(X_BA_[arm].inverse() * p_B);
  }

  const Maps& made_;
  const ReachabilityParams& params_;
  const std::vector<MapReport>& reports_;
  const std::vector<std::shared_ptr<const ReachabilityMap>>& maps_;
  std::vector<Pose> X_BA_;
};

TEST_P(ShippedMaps, AreEqualVoxelByVoxel) {
  const auto mirror = findArmMirror(model_, ArmId(0), ArmId(1), q_);
  ASSERT_TRUE(mirror.has_value());
  EXPECT_EQ(reports_[0].image_of, -1);
  EXPECT_EQ(reports_[1].image_of, 0) << reports_[1].why_own;
  EXPECT_EQ(maps_[0]->filledVoxels(), maps_[1]->filledVoxels());
  const ArmKinematics to(model_, ArmId(1));
  ArmSelfCollision self(model_, ArmId(1), q_);
  std::size_t filled = 0, touching = 0;
  forEachCentre([&](const Eigen::Vector3d& p_A) {
    const ReachabilityVoxel* a = maps_[0]->find(p_A);
    const ReachabilityVoxel* b = maps_[1]->find(mirror->S_ToFrom * p_A);
    ASSERT_EQ(a == nullptr, b == nullptr) << p_A.transpose();
    if (a == nullptr) return;
    ++filled;
    EXPECT_EQ(a->manipulability, b->manipulability);
    EXPECT_EQ(a->samples, b->samples);
    EXPECT_EQ(std::popcount(a->directions), std::popcount(b->directions));
    // The image's seed is the image arm's own: it reaches this voxel, this way.
    ArmVector q(to.dofs());
    for (int i = 0; i < to.dofs(); ++i) q[i] = double{b->q_seed[static_cast<std::size_t>(i)]};
    const Pose X_AT = to.toolPose(q);
    const Eigen::Vector3d off = X_AT.translation() - mirror->S_ToFrom * p_A;
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 0.5 * params_.voxel + 1e-5);
    const Eigen::Vector3d approach = X_AT.linear() * model_.arms[1].approach_axis;
    const double to_edge = 1e-4;  // of a direction bin, for the seed's 32 bits
    bool seen = false;
    for (const double dx : {-to_edge, to_edge}) {
      for (const double dz : {-to_edge, to_edge}) {
        const Eigen::Vector3d near = (approach + Eigen::Vector3d(dx, -dx, dz)).normalized();
        seen = seen || (b->directions >> directionBin(near) & 1) != 0;
      }
    }
    EXPECT_TRUE(seen) << p_A.transpose();
    touching += self.touches(q) ? 1 : 0;
  });
  EXPECT_EQ(filled, maps_[0]->filledVoxels());
  // The hands are not images of each other in all shapes.
  EXPECT_LE(static_cast<double>(touching), 0.02 * static_cast<double>(filled));
}

TEST_P(ShippedMaps, ChooseTheMirroredArmForAMirroredStart) {
  SeededRandom random(5);
  int left = 0, right = 0;
  for (int n = 0; n < 50'000; ++n) {
    const Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 2));
    const Eigen::Vector3d image = p.cwiseProduct(Eigen::Vector3d(1, -1, 1));
    EXPECT_EQ(entry(0, p), entry(1, image)) << p.transpose();
    EXPECT_EQ(entry(1, p), entry(0, image)) << p.transpose();
    left += entry(0, p) > entry(1, p) ? 1 : 0;
    right += entry(0, p) < entry(1, p) ? 1 : 0;
  }
  EXPECT_GT(std::min(left, right), 2000);
}

TEST_P(ShippedMaps, HaveEnoughSamplesWhereTheChoiceIsClose) {
  EXPECT_GT(reports_[0].near_ties, 100u);
  std::size_t close = 0, few = 0;
  forEachCentre([&](const Eigen::Vector3d& p_A) {
    const ReachabilityVoxel* a = maps_[0]->find(p_A);
    const ReachabilityVoxel* b = maps_[1]->find(X_BA_[1].inverse() * (X_BA_[0] * p_A));
    if (a == nullptr || b == nullptr) return;
    const double mean = 0.5 * (double{a->manipulability} + double{b->manipulability});
    if (std::abs(double{a->manipulability} - double{b->manipulability}) > 0.05 * mean) return;
    ++close;
    few += a->samples < params_.tie_samples ? 1 : 0;
  });
  EXPECT_GT(close, 50u);
  // What fell short is entered too rarely, and counted.
  EXPECT_LE(few, reports_[0].near_ties_short);
  EXPECT_LT(static_cast<double>(few), 0.1 * static_cast<double>(close));
}

INSTANTIATE_TEST_SUITE_P(Arms, ShippedRobot, ::testing::Values("crichton", "hubo", "person"));
INSTANTIATE_TEST_SUITE_P(Arms, ShippedMaps, ::testing::Values("crichton", "hubo", "person"));

TEST(MirroredArms, KeepMapsOfTheirOwnWhereOneTouchesMuchMore) {
  const RobotModel model = shipped("person");
  const RobotVector q = RobotVector::Zero(model.dofs());
  const TemporaryFolder folder;
  const std::vector<std::filesystem::path> files{folder / "0", folder / "1"};
  const auto reportWith = [&](double part) {
    // The second arm alone touches in this part of its first joint's range.
    const ArmKinematics arm(model, ArmId(1));
    const double below = arm.lower()[0] + part * (arm.upper()[0] - arm.lower()[0]);
    const auto built =
        ReachabilityMap::build(model, q, {.samples = 30'000},
                               {[](const ArmVector&) { return false; },
                                [below](const ArmVector& at) { return at[0] < below; }},
                               files, {}, Deadline());
    if (!built) throw std::runtime_error(built.error().detail);
    return built->back();
  };
  EXPECT_EQ(reportWith(0.01).image_of, 0);
  const MapReport own = reportWith(0.1);
  EXPECT_EQ(own.image_of, -1);
  EXPECT_THAT(own.why_own, HasSubstr("% of mirrored configurations"));
}

}  // namespace
}  // namespace handover::test
