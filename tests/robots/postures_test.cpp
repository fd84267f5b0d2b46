// SPDX-License-Identifier: Apache-2.0
// Named states, the pairs that are never tested, and which way the fingers close.
#include "robot_files.hpp"

#include <gmock/gmock.h>
#include <tinyxml2.h>

#include <cmath>

namespace handover {
namespace {

class RobotSrdf : public ::testing::TestWithParam<const char*> {
 protected:
  RobotSrdf() {
    const std::string name = GetParam();
    document_.LoadFile((testing::robotsFolder() / name / (name + ".srdf")).c_str());
    robot_ = document_.FirstChildElement("robot");
  }

  RobotModel model_ = testing::loadBody(GetParam());
  tinyxml2::XMLDocument document_;
  const tinyxml2::XMLElement* robot_ = nullptr;
};

TEST_P(RobotSrdf, NamedStatesAreWithinLimitsAsWritten) {
  ASSERT_NE(robot_, nullptr);
  std::map<std::string, std::set<std::string>> joints;
  for (auto state = robot_->FirstChildElement("group_state"); state;
       state = state->NextSiblingElement("group_state")) {
    for (auto value = state->FirstChildElement("joint"); value;
         value = value->NextSiblingElement("joint")) {
      const JointId index = model_.findJoint(value->Attribute("name"));
      ASSERT_TRUE(index.valid()) << value->Attribute("name");
      const Joint& joint = model_.joints[index];
      const double q = value->DoubleAttribute("value", NAN);
      EXPECT_GE(q, joint.lower) << state->Attribute("name") << " " << joint.name;
      EXPECT_LE(q, joint.upper) << state->Attribute("name") << " " << joint.name;
      joints[state->Attribute("name")].insert(joint.name);
    }
  }
  EXPECT_GE(joints.size(), 2u);
  // Nothing is left to a default.
  for (const auto& [state, named] : joints) {
    EXPECT_EQ(static_cast<int>(named.size()), model_.dofs()) << state;
  }
}

TEST_P(RobotSrdf, DisabledPairsNameLinksWithAReasonThatHolds) {
  ASSERT_NE(robot_, nullptr);
  int pairs = 0;
  for (auto pair = robot_->FirstChildElement("disable_collisions"); pair;
       pair = pair->NextSiblingElement("disable_collisions")) {
    const LinkId a = model_.findLink(pair->Attribute("link1"));
    const LinkId b = model_.findLink(pair->Attribute("link2"));
    ASSERT_TRUE(a.valid() && b.valid())
        << pair->Attribute("link1") << " " << pair->Attribute("link2");
    const std::string reason = pair->Attribute("reason");
    EXPECT_THAT(reason, ::testing::AnyOf("Adjacent", "Always"));
    EXPECT_EQ(model_.adjacent(a, b), reason == "Adjacent") << pair->Attribute("link1");
    ++pairs;
  }
  EXPECT_EQ(static_cast<int>(model_.disabled_pairs.size()), pairs) << "a pair is written twice";
}

INSTANTIATE_TEST_SUITE_P(Robots, RobotSrdf, ::testing::Values("crichton", "hubo", "person"));

/// Distance of a point of a link from the palm's axis when some joints are moved from a named
/// state.
double distanceFromAxis(const RobotModel& model, const char* state,
                        const std::map<std::string, double>& moved, const char* palm,
                        const std::string& link, const Eigen::Vector3d& p_L) {
  RobotVector q = model.named_states.at(state);
  for (const auto& [joint, value] : moved) {
    q[model.joints[model.findJoint(joint)].dof.value()] = value;
  }
  std::vector<Pose> X_WL;
  linkPoses(model, Pose::Identity(), q, X_WL);
  const Pose& X_WP = X_WL[model.findLink(palm)];
  const Pose& X_WL_link = X_WL[model.findLink(link)];
  return (X_WP.inverse() * (X_WL_link * p_L)).head<2>().norm();
}

TEST(SdhFingers, CloseTowardsThePalmsAxisWithPositiveAngles) {
  const RobotModel model = testing::loadBody("crichton");
  for (const std::string side : {"left", "right"}) {
    const std::string palm = side + "_palm_link";
    for (const std::string finger : {"_finger_1", "_finger_2", "_thumb_"}) {
      const std::string tip = side + finger + "3_link";
      const auto at = [&](double proximal, double distal) {
        return distanceFromAxis(
            model, "home",
            {{side + finger + "2_joint", proximal}, {side + finger + "3_joint", distal}},
            palm.c_str(), tip, {0, 0, 0.06});
      };
      EXPECT_GT(at(-0.9, 0.45), at(-0.4, 0.45));
      EXPECT_GT(at(-0.4, 0.45), at(-0.2, 0.45));
      EXPECT_GT(at(-0.9, 0.45), at(-0.9, 0.8));
    }
  }
}

TEST(SdhFingers, OpenWiderThanTheCupAtTheGraspLink) {
  const RobotModel model = testing::loadBody("crichton");
  std::vector<Pose> X_WL;
  linkPoses(model, Pose::Identity(), model.named_states.at("home"), X_WL);
  for (const std::string side : {"left", "right"}) {
    const Pose X_TW = X_WL[model.findLink(side + "_grasp_link")].inverse();
    // Free width along palm x within 1 cm of the grasp link's height.
    double thumb = -1, fingers = 1;
    for (const std::string finger : {"_finger_1", "_finger_2", "_thumb_"}) {
      for (const char* phalanx : {"2_link", "3_link"}) {
        const auto link = static_cast<std::size_t>(model.findLink(side + finger + phalanx));
        for (const Shape& shape : model.links[link].collision) {
          const auto& hull = std::get<ConvexShape>(shape.geometry);
          for (const auto& t : hull.triangles) {
            for (std::size_t i = 0; i < 3; ++i) {
              // Points along the hull's edges: its silhouette at that height.
              const Eigen::Vector3d a =
                  X_TW * X_WL[link] * shape.X_BS * hull.vertices[static_cast<std::size_t>(t[i])];
              const Eigen::Vector3d b = X_TW * X_WL[link] * shape.X_BS *
                                        hull.vertices[static_cast<std::size_t>(t[(i + 1) % 3])];
              for (double s = 0; s <= 1; s += 0.02) {
                const Eigen::Vector3d p = a + s * (b - a);
                if (std::abs(p.z()) > 0.01) continue;
                if (finger == "_thumb_") {
                  thumb = std::max(thumb, p.x());
                } else {
                  fingers = std::min(fingers, p.x());
                }
              }
            }
          }
        }
      }
    }
    EXPECT_GT(fingers - thumb, 0.13) << side;
  }
}

TEST(HuboFingers, CloseTowardsThePalmsAxisWithPositiveAngles) {
  const RobotModel model = testing::loadBody("hubo");
  for (const auto& [palm, prefix, fingers] :
       {std::tuple{"leftPalm", "LF", 3}, std::tuple{"rightPalm", "RF", 4}}) {
    for (int finger = 1; finger <= fingers; ++finger) {
      const std::string name = prefix + std::to_string(finger);
      const auto x = [&](double proximal, double middle, double distal) {
        RobotVector q = model.named_states.at("standing");
        const double values[] = {proximal, middle, distal};
        for (int k = 0; k < 3; ++k) {
          const JointId joint = model.findJoint(name + std::to_string(k + 1));
          q[model.joints[joint].dof.value()] = values[k];
        }
        std::vector<Pose> X_WL;
        linkPoses(model, Pose::Identity(), q, X_WL);
        // The rows of fingers face each other along the palm's x.
        return std::abs((X_WL[model.findLink(palm)].inverse() *
                         X_WL[model.findLink("Body_" + name + "3")] * Eigen::Vector3d(0, 0, -0.03))
                            .x());
      };
      EXPECT_GT(x(-1.0, 0.2, 0.2), 0.075) << name;
      EXPECT_GT(x(-1.0, 0.2, 0.2), x(-0.5, 0.2, 0.2)) << name;
      EXPECT_GT(x(-0.5, 0.2, 0.2), x(0.0, 0.2, 0.2)) << name;
      EXPECT_GT(x(-1.0, 0.2, 0.2), x(-1.0, 0.6, 0.2)) << name;
      EXPECT_GT(x(-1.0, 0.2, 0.2), x(-1.0, 0.2, 0.6)) << name;
    }
  }
}

}  // namespace
}  // namespace handover
