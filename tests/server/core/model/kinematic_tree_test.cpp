// SPDX-License-Identifier: Apache-2.0
// Forward kinematics against KDL on random trees.
#include "core/model/robot_model.hpp"

#include <gtest/gtest.h>
#include <kdl/frames.hpp>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>

#include <numbers>
#include <random>

namespace handover {
namespace {

class RandomTree {
 public:
  explicit RandomTree(std::uint64_t seed) : generator_(seed) {
    model.links.push_back(Link{"link0", {}, {}});
    for (int i = 1; i <= 20; ++i) addLink(i);
  }

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator_);
  }

  Pose pose() {
    Pose X = Pose::Identity();
    X.linear() = Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))
                     .normalized()
                     .toRotationMatrix();
    X.translation() << uniform(-1, 1), uniform(-1, 1), uniform(-1, 1);
    return X;
  }

  RobotVector configuration() {
    RobotVector q(model.dofs());
    for (auto& value : q) value = uniform(-3, 3);
    return q;
  }

  RobotModel model;

 private:
  void addLink(int index) {
    Joint joint;
    joint.name = "joint" + std::to_string(index);
    joint.type = static_cast<JointType>(generator_() % 3);
    joint.parent_link = LinkId(generator_() % static_cast<unsigned>(index));
    joint.child_link = LinkId(index);
    joint.X_PJ = pose();
    joint.axis = Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    if (joint.type != JointType::kFixed) giveDof(joint);
    model.joints.push_back(joint);
    model.links.push_back(Link{"link" + std::to_string(index), JointId(index - 1), {}});
  }

  void giveDof(Joint& joint) {
    if (model.dofs() > 0 && generator_() % 4 == 0) {
      joint.mimic = true;
      joint.mimic_multiplier = uniform(-2, 2);
      joint.mimic_offset = uniform(-1, 1);
      joint.dof = DofId(generator_() % static_cast<unsigned>(model.dofs()));
    } else {
      joint.dof = DofId(model.dofs());
      model.dof_joints.push_back(JointId(joint.child_link.value() - 1));
    }
  }

  std::mt19937_64 generator_;
};

KDL::Frame toKdl(const Pose& X) {
  const Eigen::Matrix3d R = X.linear();
  const Eigen::Vector3d p = X.translation();
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                        R(2, 2)),
          KDL::Vector(p.x(), p.y(), p.z())};
}

KDL::Joint toKdl(const Joint& joint) {
  const KDL::Frame F = toKdl(joint.X_PJ);
  const KDL::Vector axis = F.M * KDL::Vector(joint.axis.x(), joint.axis.y(), joint.axis.z());
  switch (joint.type) {
    case JointType::kFixed:
      return KDL::Joint(joint.name, KDL::Joint::None);
    case JointType::kRevolute:
      return {joint.name, F.p, axis, KDL::Joint::RotAxis};
    case JointType::kPrismatic:
      return {joint.name, F.p, axis, KDL::Joint::TransAxis};
  }
  return KDL::Joint(joint.name, KDL::Joint::None);
}

KDL::Tree toKdl(const RobotModel& model) {
  KDL::Tree tree(model.links[0].name);
  for (const Joint& joint : model.joints) {
    const KDL::Segment segment(model.links[joint.child_link].name, toKdl(joint), toKdl(joint.X_PJ));
    EXPECT_TRUE(tree.addSegment(segment, model.links[joint.parent_link].name));
  }
  return tree;
}

KDL::JntArray toKdl(const RobotModel& model, const KDL::Tree& tree, const RobotVector& q) {
  KDL::JntArray positions(tree.getNrOfJoints());
  for (const auto& [name, element] : tree.getSegments()) {
    const KDL::Joint& joint = element.segment.getJoint();
    if (joint.getType() == KDL::Joint::None) continue;
    positions(element.q_nr) = model.jointPosition(model.findJoint(joint.getName()), q);
  }
  return positions;
}

TEST(LinkPoses, AgreeWithKdlOnRandomTrees) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    RandomTree random(seed);
    const RobotModel& model = random.model;
    const Pose X_WB = random.pose();
    const RobotVector q = random.configuration();
    std::vector<Pose> X_WL;
    linkPoses(model, X_WB, q, X_WL);
    ASSERT_EQ(X_WL.size(), model.links.size());

    const KDL::Tree tree = toKdl(model);
    KDL::TreeFkSolverPos_recursive solver(tree);
    // The solver copies its tree, and a copy numbers the joints anew: ask a copy for the numbers.
    const KDL::JntArray positions = toKdl(model, KDL::Tree(tree), q);
    for (std::size_t link = 0; link < model.links.size(); ++link) {
      KDL::Frame F_BL;
      ASSERT_GE(solver.JntToCart(positions, F_BL, model.links[link].name), 0);
      const KDL::Frame expected = toKdl(X_WB) * F_BL;
      const KDL::Twist off = KDL::diff(toKdl(X_WL[link]), expected);
      EXPECT_LT(off.vel.Norm() + off.rot.Norm(), 1e-12) << "seed " << seed << " link " << link;
    }
  }
}

TEST(LinkPoses, OfSomeLinksEqualTheFullOnes) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    RandomTree random(seed);
    if (random.model.dofs() == 0) continue;
    const Pose X_WB = random.pose();
    RobotVector q = random.configuration();
    std::vector<Pose> X_WL, expected;
    linkPoses(random.model, X_WB, q, X_WL);
    const int dof = static_cast<int>(seed) % random.model.dofs();
    q[dof] += 0.3;
    linkPoses(random.model, X_WB, q, expected);
    linkPosesOf(random.model, q, random.model.linksMovedBy({DofId(dof)}), X_WL);
    for (std::size_t link = 0; link < expected.size(); ++link) {
      EXPECT_EQ(X_WL[link].matrix(), expected[link].matrix());
    }
  }
}

TEST(LinkPoses, RefuseAConfigurationOfWrongSize) {
  const RandomTree random(1);
  std::vector<Pose> X_WL;
  EXPECT_THROW(linkPoses(random.model, Pose::Identity(), RobotVector::Zero(1), X_WL),
               std::invalid_argument);
}

// root -fixed- a -revolute- b -fixed- c -revolute- d
RobotModel chain() {
  RobotModel model;
  model.links.push_back(Link{"root", {}, {}});
  const JointType types[] = {JointType::kFixed, JointType::kRevolute, JointType::kFixed,
                             JointType::kRevolute};
  for (int i = 0; i < 4; ++i) {
    Joint joint;
    joint.name = "j" + std::to_string(i);
    joint.type = types[i];
    joint.parent_link = LinkId(i);
    joint.child_link = LinkId(i + 1);
    if (joint.type == JointType::kRevolute) {
      joint.dof = DofId(model.dofs());
      model.dof_joints.push_back(JointId(i));
    }
    model.joints.push_back(joint);
    model.links.push_back(Link{std::string(1, static_cast<char>('a' + i)), JointId(i), {}});
  }
  return model;
}

TEST(RobotModel, LinksOfNeighbouringRigidGroupsAreAdjacent) {
  const RobotModel model = chain();
  const auto adjacent = [&model](const char* a, const char* b) {
    EXPECT_EQ(model.adjacent(model.findLink(a), model.findLink(b)),
              model.adjacent(model.findLink(b), model.findLink(a)));
    return model.adjacent(model.findLink(a), model.findLink(b));
  };
  EXPECT_TRUE(adjacent("root", "a"));
  EXPECT_TRUE(adjacent("root", "b"));
  EXPECT_TRUE(adjacent("root", "c"));
  EXPECT_TRUE(adjacent("b", "d"));
  EXPECT_FALSE(adjacent("a", "d"));
  EXPECT_FALSE(adjacent("root", "d"));
}

TEST(RobotModel, LinksMovedByADofAreThoseBelowIt) {
  const RobotModel model = chain();
  EXPECT_EQ(model.linksMovedBy({DofId(0)}), (std::vector<LinkId>{LinkId(2), LinkId(3), LinkId(4)}));
  EXPECT_EQ(model.linksMovedBy({DofId(1)}), (std::vector<LinkId>{LinkId(4)}));
  EXPECT_EQ(model.linksMovedBy({}), std::vector<LinkId>{});
}

TEST(RobotModel, UnknownNamesHaveNoIndex) {
  const RobotModel model = chain();
  EXPECT_FALSE(model.findLink("nobody").valid());
  EXPECT_EQ(model.findJoint("j2"), JointId(2));
  EXPECT_FALSE(model.findArm("").valid());
  EXPECT_FALSE(model.findHand("left").valid());
}

}  // namespace
}  // namespace handover
