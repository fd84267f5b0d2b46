// SPDX-License-Identifier: Apache-2.0
// The property that planning stands on: in random states of both robots in the butler cell, nothing
// that FCL finds to overlap by more than 1 mm is missed, and nothing is reported that FCL finds
// more than 3 mm apart.
#include "core/collision/collision_scene.hpp"
#include "fcl_shapes.hpp"
#include "random_shapes.hpp"
#include "settings/cell_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace handover::test {
namespace {

constexpr int kStates = 10000;

struct FclBody {
  std::vector<FclShape> shapes;
  std::vector<Eigen::Vector3d> p_WBall;  // of each shape's ball, at the state tested
};

std::shared_ptr<const Scene> butler() {
  const std::filesystem::path root = HANDOVER_SOURCE_DIR;
  ModelCache models;
  const Cell cell = Cell::load(root / "config/cells/butler.yaml", root, models);
  return std::get<Cell::Instance>(cell.instantiate({}, 0)).scene;
}

// Shapes by body, in the order of body ids: links with shapes first, then the objects.
std::vector<FclBody> fclBodies(const Scene& scene) {
  std::vector<FclBody> bodies;
  const auto add = [&](const std::vector<Shape>& shapes) {
    FclBody body;
    for (const Shape& shape : shapes) body.shapes.emplace_back(shape);
    body.p_WBall.resize(shapes.size());
    bodies.push_back(std::move(body));
  };
  for (const SceneRobot& robot : scene.robots) {
    for (const Link& link : robot.model->links) {
      if (!link.collision.empty()) add(link.collision);
    }
  }
  for (const SceneObject& object : scene.objects) add(object.shapes);
  return bodies;
}

class ButlerStates : public testing::Test {
 protected:
  ButlerStates()
      : scene_(butler()),
        world_(std::make_shared<const CollisionScene>(*scene_)),
        fcl_(fclBodies(*scene_)),
        pairs_(world_.makePairs(movingBodies(), BodyPairs(world_.scene().bodies()))) {}

  std::vector<BodyId> movingBodies() const {
    std::vector<BodyId> moving;
    for (std::size_t r = 0; r < scene_->robots.size(); ++r) {
      for (std::size_t l = 0; l < scene_->robots[r].model->links.size(); ++l) {
        const BodyId body = world_.scene().linkBody(RobotId(r), LinkId(l));
        if (body.valid()) moving.push_back(body);
      }
    }
    for (std::size_t o = 0; o < scene_->objects.size(); ++o) {
      if (scene_->objects[o].attached_to) {
        moving.push_back(world_.scene().objectBody(ObjectId(o)));
      }
    }
    return moving;
  }

  void setRandomState(RandomShapes& random) {
    std::vector<Pose> X_WL;
    for (std::size_t r = 0; r < scene_->robots.size(); ++r) {
      const SceneRobot& robot = scene_->robots[r];
      RobotVector q(robot.model->dofs());
      for (int dof = 0; dof < robot.model->dofs(); ++dof) {
        const Joint& joint = robot.model->joints[robot.model->dof_joints[dof]];
        q[dof] = random.uniform(joint.lower, joint.upper);
      }
      linkPoses(*robot.model, robot.X_WB, q, X_WL);
      world_.setRobot(RobotId(r), X_WL);
    }
    for (std::size_t b = 0; b < fcl_.size(); ++b) {
      const Pose& X_WB = world_.pose(BodyId(b));
      for (std::size_t s = 0; s < fcl_[b].shapes.size(); ++s) {
        fcl_[b].p_WBall[s] = X_WB * fcl_[b].shapes[s].ball_middle;
      }
    }
  }

  // Calls visit(shape of a, shape of b) for those that may be nearer than 4 mm, until it says true.
  template <typename Visit>
  bool anyNearShapes(BodyId a, BodyId b, const Visit& visit) const {
    const FclBody& body_a = fcl_[a];
    const FclBody& body_b = fcl_[b];
    for (std::size_t i = 0; i < body_a.shapes.size(); ++i) {
      for (std::size_t j = 0; j < body_b.shapes.size(); ++j) {
        const double reach = body_a.shapes[i].ball_radius + body_b.shapes[j].ball_radius + 0.004;
        if ((body_a.p_WBall[i] - body_b.p_WBall[j]).squaredNorm() > reach * reach) continue;
        if (visit(body_a.shapes[i], body_b.shapes[j])) return true;
      }
    }
    return false;
  }

  bool fclFindsOverlap(BodyId a, BodyId b) const {
    return anyNearShapes(a, b, [&](const FclShape& shape_a, const FclShape& shape_b) {
      return fclOverlap(shape_a, world_.pose(a), shape_b, world_.pose(b));
    });
  }

  bool fclFindsWithin(BodyId a, BodyId b, double limit) const {
    return anyNearShapes(a, b, [&](const FclShape& shape_a, const FclShape& shape_b) {
      return fclDistance(shape_a, world_.pose(a), shape_b, world_.pose(b)).low <= limit;
    });
  }

  std::shared_ptr<const Scene> scene_;
  CollisionWorld world_;
  std::vector<FclBody> fcl_;
  PairList pairs_;
};

TEST_F(ButlerStates, ContactsAreFclsContacts) {
  RandomShapes random(2026);
  long reported = 0, free_states = 0;
  for (int state = 0; state < kStates; ++state) {
    setRandomState(random);
    std::vector<BodyContact> contacts = world_.contacts(pairs_);
    EXPECT_EQ(world_.isFree(pairs_), contacts.empty()) << "state " << state;
    free_states += contacts.empty() ? 1 : 0;
    BodyPairs touching(world_.scene().bodies());
    for (const BodyContact& it : contacts) touching.insert(it.a, it.b);
    for (const auto& [a, b] : pairs_.pairs()) {
      const std::string names = world_.scene().name(a) + " and " + world_.scene().name(b);
      if (!touching.contains(a, b)) {
        ASSERT_FALSE(fclFindsOverlap(a, b)) << "state " << state << ": missed " << names;
      } else {
        ASSERT_TRUE(fclFindsWithin(a, b, 0.003)) << "state " << state << ": false " << names;
        ++reported;
      }
    }
  }
  RecordProperty("contacts", std::to_string(reported));
  EXPECT_GT(reported, kStates);
  EXPECT_GT(free_states, 0);
}

}  // namespace
}  // namespace handover::test
