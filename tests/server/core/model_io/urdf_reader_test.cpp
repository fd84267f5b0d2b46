// SPDX-License-Identifier: Apache-2.0
// What is written into a URDF is what comes out.
#include "core/model_io/urdf_reader.hpp"

#include "support/meshes.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

namespace handover {
namespace {

struct Written {
  std::string type, parent;
  Eigen::Vector3d xyz, rpy, axis, shape_xyz, shape_rpy;
  double lower, upper;
};

/// Joint i leads to link i + 1; link 0 is the root.
std::vector<Written> randomTree(std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-3, 3);
  const auto vector = [&] {
    const double x = uniform(generator), y = uniform(generator);
    return Eigen::Vector3d(x, y, uniform(generator));
  };
  const char* const types[] = {"fixed", "revolute", "continuous", "prismatic"};
  std::vector<Written> joints;
  for (unsigned i = 0; i < 15; ++i) {
    const double lower = uniform(generator);
    joints.push_back({types[generator() % 4], "l" + std::to_string(generator() % (i + 1)), vector(),
                      vector(), vector(), vector(), vector(), lower, lower + 1});
  }
  return joints;
}

std::string urdfOf(const std::vector<Written>& joints) {
  std::ostringstream out;
  out.precision(17);
  const auto origin = [&out](const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
    out << "<origin xyz='" << xyz.transpose() << "' rpy='" << rpy.transpose() << "'/>";
  };
  out << "<robot name='random'><link name='l0'/>";
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Written& joint = joints[i];
    out << "<link name='l" << i + 1 << "'><collision>";
    origin(joint.shape_xyz, joint.shape_rpy);
    out << "<geometry><box size='1 2 3'/></geometry></collision></link>\n<joint name='j" << i
        << "' type='" << joint.type << "'><parent link='" << joint.parent << "'/><child link='l"
        << i + 1 << "'/>";
    origin(joint.xyz, joint.rpy);
    out << "<axis xyz='" << joint.axis.transpose() << "'/><limit lower='" << joint.lower
        << "' upper='" << joint.upper << "' velocity='0.1' effort='2'/></joint>\n";
  }
  out << "</robot>";
  return out.str();
}

Pose poseOf(const Eigen::Vector3d& xyz, const Eigen::Vector3d& rpy) {
  Pose X = Pose::Identity();
  X.linear() = rotationFromRpy(rpy.x(), rpy.y(), rpy.z());
  X.translation() = xyz;
  return X;
}

void expectSame(const UrdfModel& model, const Joint& joint, const Written& written) {
  const Link& child = model.links[joint.child_link];
  EXPECT_EQ(model.links[joint.parent_link].name, written.parent);
  EXPECT_EQ(child.name, "l" + std::to_string(std::stoi(joint.name.substr(1)) + 1));
  EXPECT_EQ(joint.X_PJ.translation(), written.xyz);
  EXPECT_TRUE(joint.X_PJ.isApprox(poseOf(written.xyz, written.rpy), 1e-14));
  EXPECT_TRUE(
      child.collision.at(0).X_BS.isApprox(poseOf(written.shape_xyz, written.shape_rpy), 1e-14));
  EXPECT_EQ(std::get<BoxShape>(child.collision.at(0).geometry).size, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(joint.type, written.type == "fixed"       ? JointType::kFixed
                        : written.type == "prismatic" ? JointType::kPrismatic
                                                      : JointType::kRevolute);
  if (written.type == "fixed") return;
  EXPECT_EQ(joint.axis, written.axis.normalized());
  EXPECT_EQ(joint.velocity, 0.1);
  EXPECT_EQ(joint.lower, written.type == "continuous" ? -M_PI : written.lower);
  EXPECT_EQ(joint.upper, written.type == "continuous" ? M_PI : written.upper);
}

TEST(UrdfReader, ReadsWhatIsWritten) {
  const test::TemporaryFolder folder;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const std::vector<Written> joints = randomTree(seed);
    std::vector<FileFault> faults;
    const UrdfModel model = readUrdf(folder.write("r.urdf", urdfOf(joints)), "r.urdf", faults);
    ASSERT_TRUE(faults.empty()) << faults[0].text();
    EXPECT_EQ(model.links[0].name, "l0");
    ASSERT_EQ(model.joints.size(), joints.size());
    for (const Joint& joint : model.joints) {
      expectSame(model, joint,
                 joints.at(static_cast<std::size_t>(std::stoi(joint.name.substr(1)))));
    }
  }
}

TEST(UrdfReader, DividesACollisionMeshThatIsNotConvex) {
  const test::TemporaryFolder folder;
  folder.write("angle.stl", test::stlText(test::angleMesh()));
  const auto file =
      folder.write("r.urdf",
                   "<robot name='r'><link name='l'><collision><origin xyz='0 0 1'/><geometry>"
                   "<mesh filename='angle.stl'/></geometry></collision></link></robot>");
  std::vector<FileFault> faults;
  const UrdfModel model = readUrdf(file, "r.urdf", faults);
  ASSERT_TRUE(faults.empty()) << faults[0].text();
  ASSERT_EQ(model.links.at(0).collision.size(), 2u);
  for (const Shape& shape : model.links[0].collision) {
    EXPECT_EQ(shape.X_BS.translation(), Eigen::Vector3d(0, 0, 1));
  }
}

}  // namespace
}  // namespace handover
