// SPDX-License-Identifier: Apache-2.0
#include "state_obj.hpp"

#include "sample_plan.hpp"

#include <handover/client/plan_file.hpp>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

namespace handover::ctl {
namespace {

using view::test::SampleCell;

struct Group {
  Eigen::AlignedBox3d box;
  int triangles = 0;
};

/// The groups of a Wavefront text; corners of faces are counted through the whole file.
std::map<std::string, Group> groupsOf(const std::string& text) {
  std::map<std::string, Group> groups;
  std::vector<Eigen::Vector3d> points;
  Group* group = nullptr;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "o") {
      std::string name;
      words >> name;
      EXPECT_FALSE(groups.contains(name)) << name;
      group = &groups[name];
    } else if (kind == "v") {
      Eigen::Vector3d p;
      words >> p.x() >> p.y() >> p.z();
      points.push_back(p);
    } else if (kind == "f" && group != nullptr) {
      ++group->triangles;
      for (std::size_t corner = 0; words >> corner;) group->box.extend(points.at(corner - 1));
    }
  }
  return groups;
}

class StateObj : public testing::Test {
 protected:
  std::map<std::string, Group> at(const std::string& kind) const {
    return groupsOf(stateObj(cell_.plan().dump(), cell_.root(), kind));
  }

  static void expectBox(const Group& group, const Eigen::Vector3d& centre,
                        const Eigen::Vector3d& size) {
    EXPECT_LT((group.box.center() - centre).norm(), 1e-5) << group.box.center().transpose();
    EXPECT_LT((group.box.sizes() - size).norm(), 1e-5) << group.box.sizes().transpose();
  }

  Eigen::Vector3d start() const {
    const auto xyz = cell_.plan()["scene"]["start"]["X_WO"]["xyz"].get<std::array<double, 3>>();
    return {xyz[0], xyz[1], xyz[2]};
  }

  Eigen::Vector3d goal() const {
    const auto xyz = cell_.plan()["scene"]["goal"]["X_WO"]["xyz"].get<std::array<double, 3>>();
    return {xyz[0], xyz[1], xyz[2]};
  }

  SampleCell cell_;
};

TEST_F(StateObj, ShowsTheWholeCellWhereItStartsAndEnds) {
  const auto begin = at("start"), end = at("end");
  expectBox(begin.at("box"), start(), {0.04, 0.04, 0.12});
  expectBox(end.at("box"), goal(), {0.04, 0.04, 0.12});  // turned by a quarter
  expectBox(begin.at("table"), {-0.4, 0, -0.01}, {0.4, 0.5, 0.02});
  EXPECT_EQ(begin.at("table").triangles, 12);
  EXPECT_NEAR(begin.at("ball").box.sizes().z(), 0.1, 1e-5);
  EXPECT_GT(begin.at("shelf").triangles, 12);  // a box and a cylinder
  int links = 0;
  for (const auto& [name, group] : begin) links += name.starts_with("duo/") ? 1 : 0;
  EXPECT_GE(links, 4);
}

TEST_F(StateObj, TakesAStageByItsIndexOrByActionAndHolder) {
  const auto lifted = at("lift.0");
  expectBox(lifted.at("box"), start() + Eigen::Vector3d(0, 0, 0.05), {0.04, 0.04, 0.12});
  expectBox(at("3").at("box"), lifted.at("box").box.center(), {0.04, 0.04, 0.12});
}

TEST_F(StateObj, NamesOnlyMomentsThatThereAre) {
  for (const char* kind : {"start", "end", "0", "17", "grasp.1", "home.2"}) {
    EXPECT_TRUE(namesState(kind)) << kind;
  }
  for (const char* kind : {"", "grasp", "nap.1", "grasp.", "grasp.x", "-1", "1.5"}) {
    EXPECT_FALSE(namesState(kind)) << kind;
  }
  EXPECT_THROW(at("lift.1"), client::PlanFileError);
  EXPECT_THROW(at("99"), client::PlanFileError);
  EXPECT_THROW(stateObj(cell_.failure().dump(), cell_.root(), "start"), client::PlanFileError);
}

}  // namespace
}  // namespace handover::ctl
