// SPDX-License-Identifier: Apache-2.0
// Our URDF reader against urdfdom on the same text.
#include "core/model/urdf_reader.hpp"
#include "temporary_folder.hpp"

#include <urdf_parser/urdf_parser.h>

#include <random>
#include <sstream>

namespace handover {
namespace {

/// A random tree of links with random numbers, written out with 17 digits.
std::string randomUrdf(std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-3, 3);
  std::ostringstream out;
  out.precision(17);
  const auto three = [&] {
    std::ostringstream text;
    text.precision(17);
    text << uniform(generator) << " " << uniform(generator) << " " << uniform(generator);
    return text.str();
  };
  const char* const types[] = {"fixed", "revolute", "continuous", "prismatic"};
  out << "<robot name='random'><link name='l0'/>";
  for (unsigned i = 1; i <= 15; ++i) {
    const double low = uniform(generator);
    out << "<link name='l" << i << "'><collision><origin xyz='" << three() << "' rpy='" << three()
        << "'/><geometry><box size='1 2 3'/></geometry></collision></link>\n<joint name='j" << i
        << "' type='" << types[generator() % 4] << "'><parent link='l" << generator() % i
        << "'/><child link='l" << i << "'/><origin xyz='" << three() << "' rpy='" << three()
        << "'/><axis xyz='" << three() << "'/><limit lower='" << low << "' upper='" << low + 1
        << "' velocity='1' effort='2'/></joint>\n";
  }
  out << "</robot>";
  return out.str();
}

Pose toPose(const urdf::Pose& pose) {
  Pose X = Pose::Identity();
  X.linear() =
      Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z)
          .toRotationMatrix();
  X.translation() << pose.position.x, pose.position.y, pose.position.z;
  return X;
}

TEST(UrdfOracle, ReadsWhatUrdfdomReads) {
  const handover::testing::TemporaryFolder folder;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const std::string text = randomUrdf(seed);
    std::vector<FileFault> faults;
    const UrdfModel ours = readUrdf(folder.write("r.urdf", text), "r.urdf", faults);
    ASSERT_TRUE(faults.empty()) << faults[0].text();
    const urdf::ModelInterfaceSharedPtr theirs = urdf::parseURDF(text);
    ASSERT_TRUE(theirs);
    EXPECT_EQ(ours.links[0].name, theirs->getRoot()->name);
    ASSERT_EQ(ours.joints.size(), theirs->joints_.size());
    for (const Joint& joint : ours.joints) {
      const auto& other = theirs->joints_.at(joint.name);
      const Link& child = ours.links[static_cast<std::size_t>(joint.child_link)];
      EXPECT_EQ(ours.links[static_cast<std::size_t>(joint.parent_link)].name,
                other->parent_link_name);
      EXPECT_EQ(child.name, other->child_link_name);
      EXPECT_TRUE(joint.X_PJ.isApprox(toPose(other->parent_to_joint_origin_transform), 1e-12));
      EXPECT_TRUE(child.collision.at(0).X_BS.isApprox(
          toPose(theirs->links_.at(child.name)->collision->origin), 1e-12));
      if (joint.type == JointType::kFixed) {
        EXPECT_EQ(other->type, urdf::Joint::FIXED);
        continue;
      }
      const Eigen::Vector3d axis(other->axis.x, other->axis.y, other->axis.z);
      EXPECT_TRUE(joint.axis.isApprox(axis.normalized(), 1e-12));
      EXPECT_EQ(joint.velocity, other->limits->velocity);
      if (other->type == urdf::Joint::CONTINUOUS) continue;
      EXPECT_EQ(joint.lower, other->limits->lower);
      EXPECT_EQ(joint.upper, other->limits->upper);
      EXPECT_EQ(joint.type == JointType::kPrismatic, other->type == urdf::Joint::PRISMATIC);
    }
  }
}

}  // namespace
}  // namespace handover
