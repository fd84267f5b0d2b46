// SPDX-License-Identifier: Apache-2.0
// All our cells: no link stands in the furniture, objects rest where tasks begin and end, and what
// an experiment draws is sound.
#include "core/collision/collision_scene.hpp"
#include "settings/cell_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

namespace handover {
namespace {

const std::filesystem::path kRoot = HANDOVER_SOURCE_DIR;

std::vector<std::string> cellNames() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kRoot / "config/cells")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string list(const std::vector<double>& values) {
  std::ostringstream text;
  text.precision(9);
  for (std::size_t i = 0; i < values.size(); ++i) text << (i == 0 ? "[" : ", ") << values[i];
  text << "]";
  return text.str();
}

/// A cell's variations as overrides; part(variation, entry) says where in the range.
template <typename Part, typename Choice>
std::vector<Override> varied(const std::vector<Variation>& variations, Part part, Choice choice) {
  std::map<std::string, std::vector<double>> values;
  std::vector<Override> overrides;
  for (const Variation& variation : variations) {
    if (!variation.choices.empty()) {
      overrides.push_back({variation.path, choice(variation.choices)});
      continue;
    }
    std::vector<double>& value = values[variation.path];
    for (std::size_t i = 0; i < variation.from.size(); ++i) {
      value.push_back(std::lerp(variation.from[i], variation.to[i], part()));
    }
    if (variation.facing) {
      const auto& place = values.at(placePath(variation));
      value.back() +=
          std::atan2((*variation.facing)[1] - place[1], (*variation.facing)[0] - place[0]) * 180 /
          std::numbers::pi;
    }
    overrides.push_back({variation.path, list(value)});
  }
  return overrides;
}

class OurCell : public testing::TestWithParam<std::string> {
 protected:
  Cell::Instance instance(const std::vector<Override>& overrides = {}) const {
    auto made = cell_.instantiate(overrides, 1);
    if (const auto* faults = std::get_if<std::vector<Fault>>(&made)) {
      throw std::runtime_error(faults->at(0).field + ": " + faults->at(0).message);
    }
    return std::get<Cell::Instance>(made);
  }

  /// The nominal cell, the ends of its ranges, then draws.
  std::vector<std::vector<Override>> draws(int count) const {
    std::mt19937_64 generator(1);
    std::uniform_real_distribution<double> even(0, 1);
    std::vector<std::vector<Override>> all{{}};
    for (int i = 0; i < count; ++i) {
      const bool corner = i < count / 2;
      all.push_back(varied(
          cell_.variations(),
          [&] { return corner ? std::round(even(generator)) : even(generator); },
          [&](const auto& choices) { return choices[generator() % choices.size()]; }));
    }
    return all;
  }

  ModelCache models_;
  Cell cell_ = Cell::load(kRoot / "config/cells" / (GetParam() + ".yaml"), kRoot, models_);
};

std::vector<BodyContact> contactsOf(CollisionWorld& world, const std::vector<BodyId>& bodies) {
  return world.contacts(world.makePairs(bodies, BodyPairs(world.scene().bodies())));
}

TEST_P(OurCell, HasNoLinkInTheFurniture) {
  std::vector<std::vector<Override>> stands{{}};
  for (const Variation& variation : cell_.variations()) {
    for (const std::string& choice : variation.choices) {
      stands.push_back({{variation.path, choice}});
    }
  }
  for (const auto& overrides : stands) {
    CollisionWorld world(std::make_shared<const CollisionScene>(*instance(overrides).scene));
    std::vector<BodyId> all;
    for (const BodyId body : IdRange<BodyId>(world.scene().bodies())) all.push_back(body);
    for (const BodyContact& contact : contactsOf(world, all)) {
      EXPECT_LT(contact.depth, 0.0005)
          << world.scene().name(contact.a) << " and " << world.scene().name(contact.b)
          << (overrides.empty() ? "" : overrides[0].value);
    }
  }
}

/// Ranges are drawn about what the file says.
TEST_P(OurCell, StandsInTheMiddleOfItsRanges) {
  std::vector<Variation> ranges = cell_.variations();
  std::erase_if(ranges, [](const Variation& variation) { return !variation.choices.empty(); });
  ASSERT_FALSE(ranges.empty());
  const Cell::Instance nominal = instance();
  const Cell::Instance middle = instance(varied(
      ranges, [] { return 0.5; }, [](const auto& choices) { return choices[0]; }));
  for (std::size_t i = 0; i < nominal.scene->robots.size(); ++i) {
    const SceneRobot &a = nominal.scene->robots[i], &b = middle.scene->robots[i];
    EXPECT_TRUE(a.X_WB.isApprox(b.X_WB, 1e-9)) << a.name;
    EXPECT_LT((a.q_start - b.q_start).cwiseAbs().maxCoeff(), 1e-9) << a.name;
  }
  for (std::size_t i = 0; i < nominal.scene->objects.size(); ++i) {
    const SceneObject &a = nominal.scene->objects[i], &b = middle.scene->objects[i];
    EXPECT_TRUE(a.X_WO.isApprox(b.X_WO, 1e-9)) << a.name;
  }
  for (std::size_t i = 0; i < nominal.tasks.size(); ++i) {
    EXPECT_TRUE(nominal.tasks[i].X_WO_start.isApprox(middle.tasks[i].X_WO_start, 1e-9));
    EXPECT_TRUE(nominal.tasks[i].X_WO_goal.isApprox(middle.tasks[i].X_WO_goal, 1e-9));
  }
}

/// What an object moved up or down by `up` [m] stands in, whatever else may touch it.
std::vector<std::string> standsIn(CollisionWorld& world, BodyId object, const Pose& X_WO,
                                  double up) {
  world.setPose(object, Eigen::Translation3d(0, 0, up) * X_WO);
  std::vector<std::string> names;
  for (const BodyContact& contact : contactsOf(world, {object})) {
    if (contact.depth <= 0) continue;
    names.push_back(world.scene().name(contact.a == object ? contact.b : contact.a));
  }
  return names;
}

TEST_P(OurCell, RestsItsObjectsWhereTasksBeginAndEnd) {
  int places = 0, holds = 0;
  for (const auto& overrides : draws(40)) {
    const Cell::Instance made = instance(overrides);
    for (const SceneTask& task : made.tasks) {
      SCOPED_TRACE(task.name + (overrides.empty() ? "" : " " + overrides[0].value));
      Scene scene = *startOf(made.scene, task);
      const ObjectId index = scene.findObject(task.object);
      scene.objects[index].resting.clear();  // a resting pair would not be tested
      CollisionWorld world(std::make_shared<const CollisionScene>(scene));
      const BodyId object = world.scene().objectBody(index);
      const auto check = [&](const Pose& X_WO, const TaskRest& rest) {
        ++places;
        const auto above = standsIn(world, object, X_WO, 0.0008);
        EXPECT_TRUE(above.empty()) << "stands in " << above[0];
        const auto below = standsIn(world, object, X_WO, -0.0018);
        ASSERT_TRUE(rest.objects.has_value()) << "the file does not say what it rests on";
        for (const std::string& support : *rest.objects) {
          EXPECT_NE(std::find(below.begin(), below.end(), support), below.end())
              << "does not rest on " << support;
        }
        EXPECT_EQ(below.size(), rest.objects->size());
      };
      if (!task.held_by) check(task.X_WO_start, task.start_rest);
      if (task.end == TransportEnd::kRelease) check(task.X_WO_goal, task.goal_rest);
      holds += task.end == TransportEnd::kHold;
    }
  }
  EXPECT_GE(places, 41);
  EXPECT_EQ(holds > 0, GetParam() == "stool" || GetParam() == "kneeling");
}

/// An experiment draws again what touches at the start; more than one in ten would fail it.
TEST_P(OurCell, StartsFreeOfContactsInItsDraws) {
  int touched = 0, drawn = 0;
  std::map<std::string, int> pairs;
  for (const auto& overrides : draws(80)) {
    const Cell::Instance made = instance(overrides);
    CollisionWorld world(std::make_shared<const CollisionScene>(*made.scene));
    std::vector<BodyId> moving;
    for (std::size_t robot = 0; robot < made.scene->robots.size(); ++robot) {
      const RobotModel& model = *made.scene->robots[robot].model;
      std::vector<DofId> dofs;
      for (const Arm& arm : model.arms) dofs.insert(dofs.end(), arm.dofs.begin(), arm.dofs.end());
      for (const BodyId body : world.scene().linkBodies(RobotId(robot), model.linksMovedBy(dofs))) {
        if (body.valid()) moving.push_back(body);
      }
    }
    const auto contacts = contactsOf(world, moving);
    for (const BodyContact& it : contacts) {
      ++pairs[world.scene().name(it.a) + " and " + world.scene().name(it.b)];
    }
    touched += !contacts.empty();
    EXPECT_TRUE(contacts.empty() || drawn > 0) << "as the file says, too";
    ++drawn;
  }
  EXPECT_LE(touched, drawn / 10) << (pairs.empty() ? "" : pairs.begin()->first);
}

INSTANTIATE_TEST_SUITE_P(Ours, OurCell, testing::ValuesIn(cellNames()),
                         [](const auto& shown) { return shown.param; });

}  // namespace
}  // namespace handover
