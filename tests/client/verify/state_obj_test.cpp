// SPDX-License-Identifier: Apache-2.0
#include "verify/state_obj.hpp"

#include "gantry_plan.hpp"
#include "verify/unreadable.hpp"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

namespace handover::verify::test {
namespace {

using testing::Contains;
using testing::Key;

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
  std::map<std::string, Group> at(const char* kind) const {
    return groupsOf(stateObj(plan_.dump(), cell_.root(), kind));
  }

  Eigen::Vector3d point(const char* name) const {
    const Json& X_WO = name == std::string("handover") ? plan_["plan"]["handovers"][0]
                                                       : plan_["scene"][name]["X_WO"];
    const auto p = X_WO["xyz"].get<std::vector<double>>();
    return {p[0], p[1], p[2]};
  }

  GantryCell cell_;
  Json plan_ = cell_.plan();
};

TEST_F(StateObj, HasEveryBodyOnce) {
  const auto groups = at("start");
  for (const Json& object : plan_["scene"]["objects"]) {
    EXPECT_THAT(groups, Contains(Key(object["name"].get<std::string>())));
  }
  int links = 0;
  for (const auto& [name, group] : groups) {
    EXPECT_GE(group.triangles, 12) << name;
    if (name.rfind("g/", 0) == 0) ++links;
  }
  EXPECT_GT(links, 3);
}

TEST_F(StateObj, HasTheObjectWhereTheStageLeftIt) {
  EXPECT_LT((at("start").at("box").box.center() - point("start")).norm(), 1e-5);
  EXPECT_LT((at("grasp.0").at("box").box.center() - point("start")).norm(), 1e-5);
  EXPECT_LT((at("carry.0").at("box").box.center() - point("handover")).norm(), 1e-4);
  EXPECT_LT((at("7").at("box").box.center() - point("handover")).norm(), 1e-4);
  EXPECT_LT((at("place.1").at("box").box.center() - point("goal")).norm(), 1e-3);
  EXPECT_LT((at("end").at("box").box.center() - point("goal")).norm(), 1e-3);
}

TEST_F(StateObj, HasTheRobotsWhereTheStageLeftThem) {
  // The giver's hand goes with what it carries; at the end all stand as at the start.
  const auto box = [&](const char* kind) { return at(kind).at("box").box; };
  for (const char* kind : {"grasp.0", "carry.0"}) {
    double nearest = 1e9;
    for (const auto& [name, group] : at(kind)) {
      if (name.rfind("g/", 0) == 0)
        nearest = std::min(nearest, group.box.exteriorDistance(box(kind)));
    }
    EXPECT_LT(nearest, 2e-3) << kind;
  }
  const auto start = at("start");
  for (const auto& [name, group] : at("end")) {
    if (name.find('/') == std::string::npos || name.find("finger") != std::string::npos) continue;
    EXPECT_LT((group.box.center() - start.at(name).box.center()).norm(), 0.1) << name;
  }
}

TEST_F(StateObj, KnowsTheStagesByName) {
  for (const char* kind : {"start", "end", "0", "15", "reach.0", "home.1"}) {
    EXPECT_TRUE(namesState(kind)) << kind;
  }
  for (const char* kind :
       {"", "giver", "Start", "grasp", "grasp.", "grasp.x", "-1", "3 ", "push.0"}) {
    EXPECT_FALSE(namesState(kind)) << kind;
  }
}

TEST_F(StateObj, RefusesWhatItCannotUnderstand) {
  EXPECT_THROW(stateObj("{", cell_.root(), "start"), Unreadable);
  EXPECT_THROW(stateObj(plan_.dump(), cell_.root() / "nowhere", "start"), Unreadable);
  EXPECT_THROW(stateObj(plan_.dump(), cell_.root(), "16"), Unreadable);
  plan_["plan"]["stages"].erase(3);
  EXPECT_THROW(stateObj(plan_.dump(), cell_.root(), "start"), Unreadable);
}

}  // namespace
}  // namespace handover::verify::test
