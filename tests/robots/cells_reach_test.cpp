// SPDX-License-Identifier: Apache-2.0
// Who can reach what in our cells: each task needs the chain that its file names, and no shorter
// one.
#include "core/kinematics/arm_kinematics.hpp"
#include "settings/cell_file.hpp"

#include <gtest/gtest.h>

#include <random>

namespace handover {
namespace {

constexpr int kSamples = 20000;

/// An arm as it stands in a cell: where its shoulder is and how far from it the tool gets.
struct PlacedArm {
  RobotId robot;
  ArmId arm;
  Eigen::Vector3d p_WShoulder;
  double reach = 0;  ///< [m], the most of many random configurations

  double from(const Eigen::Vector3d& p_W) const { return (p_W - p_WShoulder).norm(); }
};

class Reach {
 public:
  explicit Reach(const std::string& cell) {
    const std::filesystem::path root = HANDOVER_SOURCE_DIR;
    ModelCache models;
    instance_ = std::get<Cell::Instance>(
        Cell::load(root / "config/cells" / (cell + ".yaml"), root, models).instantiate({}, 1));
    for (const RobotId robot : IdRange<RobotId>(instance_.scene->robots.size())) {
      const auto& model = *instance_.scene->robots[robot].model;
      for (const ArmId arm : IdRange<ArmId>(model.arms.size())) place(robot, arm);
    }
  }

  const SceneTask& task() const { return instance_.tasks.at(0); }

  /// What may separate the object's origin from the tool that holds it, or two tools at a handover.
  double objectRadius() const {
    const ObjectId index = instance_.scene->findObject(task().object);
    double radius = 0;
    for (const Shape& shape : instance_.scene->objects.at(index).shapes) {
      if (const auto* box = std::get_if<BoxShape>(&shape.geometry)) {
        radius = std::max(radius, 0.5 * box->size.norm());
      }
    }
    return radius;
  }

  std::vector<PlacedArm> arms(const std::string& robot) const {
    std::vector<PlacedArm> of;
    for (const PlacedArm& arm : arms_) {
      if (arm.robot == instance_.scene->findRobot(robot)) of.push_back(arm);
    }
    return of;
  }

  /// Least distance [m] by which p_W is out of an arm's reach; negative: it is within.
  static double beyond(const std::vector<PlacedArm>& arms, const Eigen::Vector3d& p_W) {
    double least = std::numeric_limits<double>::infinity();
    for (const PlacedArm& arm : arms) least = std::min(least, arm.from(p_W) - arm.reach);
    return least;
  }

  /// The same for two robots' arms that shall meet.
  static double apart(const std::vector<PlacedArm>& a, const std::vector<PlacedArm>& b) {
    double least = std::numeric_limits<double>::infinity();
    for (const PlacedArm& one : a) {
      for (const PlacedArm& other : b) {
        least = std::min(least, one.from(other.p_WShoulder) - one.reach - other.reach);
      }
    }
    return least;
  }

 private:
  void place(RobotId robot, ArmId arm) {
    const SceneRobot& at = instance_.scene->robots.at(robot);
    const ArmKinematics kinematics(*at.model, arm);
    std::vector<Pose> X_WL;
    linkPoses(*at.model, at.X_WB, at.q_start, X_WL);
    const LinkId base = at.model->arms.at(arm).base_link;
    PlacedArm placed;
    placed.robot = robot;
    placed.arm = arm;
    placed.p_WShoulder = X_WL.at(static_cast<std::size_t>(base)) * kinematics.shoulder();
    std::mt19937_64 generator(1);
    for (int n = 0; n < kSamples; ++n) {
      ArmVector q(kinematics.dofs());
      for (int i = 0; i < kinematics.dofs(); ++i) {
        q[i] = std::uniform_real_distribution<double>(kinematics.lower()[i],
                                                      kinematics.upper()[i])(generator);
      }
      placed.reach = std::max(
          placed.reach, (kinematics.toolPose(q).translation() - kinematics.shoulder()).norm());
    }
    arms_.push_back(placed);
  }

  Cell::Instance instance_;
  std::vector<PlacedArm> arms_;
};

TEST(Relay, NeedsAllThreeRobots) {
  const Reach reach("relay");
  const auto first = reach.arms("first"), hubo = reach.arms("hubo"), last = reach.arms("last");
  const Eigen::Vector3d start = reach.task().X_WO_start.translation();
  const Eigen::Vector3d goal = reach.task().X_WO_goal.translation();
  const double spare = reach.objectRadius();
  // Each next to the next one's reach ...
  EXPECT_LT(Reach::beyond(first, start), 0);
  EXPECT_LT(Reach::apart(first, hubo), 0);
  EXPECT_LT(Reach::apart(hubo, last), 0);
  EXPECT_LT(Reach::beyond(last, goal), 0);
  // ... and none to the one after it.
  EXPECT_GT(Reach::beyond(hubo, start), spare);
  EXPECT_GT(Reach::beyond(last, start), spare);
  EXPECT_GT(Reach::beyond(hubo, goal), spare);
  EXPECT_GT(Reach::beyond(first, goal), spare);
  EXPECT_GT(Reach::apart(first, last), spare);
}

TEST(HandToHand, NeedsBothArms) {
  const Reach reach("hand_to_hand");
  const auto arms = reach.arms("crichton");
  ASSERT_EQ(arms.size(), 2u);
  const std::vector<PlacedArm> left{arms[0]}, right{arms[1]};
  ASSERT_GT(left[0].p_WShoulder.y(), 0);
  const Eigen::Vector3d start = reach.task().X_WO_start.translation();
  const Eigen::Vector3d goal = reach.task().X_WO_goal.translation();
  EXPECT_LT(Reach::beyond(right, start), 0);
  EXPECT_LT(Reach::beyond(left, goal), 0);
  EXPECT_GT(Reach::beyond(left, start), reach.objectRadius());
  EXPECT_GT(Reach::beyond(right, goal), reach.objectRadius());
}

TEST(ServePerson, NeedsBoth) {
  const Reach reach("serve_person");
  const auto crichton = reach.arms("crichton"), person = reach.arms("person");
  const Eigen::Vector3d start = reach.task().X_WO_start.translation();
  const Eigen::Vector3d goal = reach.task().X_WO_goal.translation();
  EXPECT_LT(Reach::beyond(crichton, start), 0);
  EXPECT_LT(Reach::apart(crichton, person), 0);
  EXPECT_LT(Reach::beyond(person, goal), 0);
  EXPECT_GT(Reach::beyond(crichton, goal), 0);
  EXPECT_GT(Reach::beyond(person, start), reach.objectRadius());
}

TEST(PickPlace, NeedsOneArm) {
  const Reach reach("pick_place");
  int able = 0;
  for (const PlacedArm& arm : reach.arms("crichton")) {
    able += Reach::beyond({arm}, reach.task().X_WO_start.translation()) < 0 &&
            Reach::beyond({arm}, reach.task().X_WO_goal.translation()) < 0;
  }
  EXPECT_EQ(able, 1);
}

}  // namespace
}  // namespace handover
