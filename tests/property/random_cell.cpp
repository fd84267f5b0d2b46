// SPDX-License-Identifier: Apache-2.0
#include "random_cell.hpp"

#include "core/planning/collision_context.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <random>

namespace handover::test {
namespace {

// Planar arms work in the plane of a lattice centre: 2.5 cm beside the world's x-z plane.
constexpr double kPlane = 0.025;

/// The same numbers on every machine, which std's distributions do not promise.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : bits_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }

  int below(int n) { return static_cast<int>(bits_() % static_cast<std::uint64_t>(n)); }

  bool chance(double p) { return between(0, 1) < p; }

  ArmVector configuration(const ArmKinematics& arm) {
    ArmVector q(arm.dofs());
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = between(arm.lower()[i], arm.upper()[i]);
    return q;
  }

 private:
  std::mt19937_64 bits_;
};

bool planar(RobotKind kind) {
  return kind == RobotKind::kPlanar || kind == RobotKind::kSlidingPlanar;
}

/// Grasps of a box: from each side, by each pair of faces that the fingers can span, at places
/// along the third edge; `most` of them, drawn.
std::shared_ptr<const GraspSet> boxGrasps(const std::array<double, 3>& size, int most, Draw& draw) {
  auto set = std::make_shared<GraspSet>();
  set->object = "box";
  std::vector<Grasp> all;
  for (int along = 0; along < 3; ++along) {
    for (int across = 0; across < 3; ++across) {
      const double width = size[static_cast<std::size_t>(across)];
      if (across == along || width > 0.07) continue;
      const int third = 3 - along - across;
      for (const double side : {1.0, -1.0}) {
        for (const double roll : {1.0, -1.0}) {
          for (const double place : {0.0, 0.3, -0.3}) {
            Grasp grasp;
            grasp.X_OT.linear().setZero();
            grasp.X_OT.linear()(along, 0) = side;
            grasp.X_OT.linear()(across, 1) = roll;
            grasp.X_OT.linear().col(2) =
                grasp.X_OT.linear().col(0).cross(grasp.X_OT.linear().col(1));
            // The tool two centimetres below the surface that the palm looks at.
            grasp.X_OT.translation()[along] =
                -side * (0.5 * size[static_cast<std::size_t>(along)] - 0.02);
            grasp.X_OT.translation()[third] = place * size[static_cast<std::size_t>(third)];
            grasp.closed = Eigen::VectorXd::Constant(1, 0.5 * width + 0.0005);
            grasp.open = Eigen::VectorXd::Constant(
                1, std::min(Gripper::kWidestOpening, 0.5 * width + 0.012));
            all.push_back(std::move(grasp));
          }
        }
      }
    }
  }
  while (static_cast<int>(set->grasps.size()) < most && !all.empty()) {
    const auto chosen = all.begin() + draw.below(static_cast<int>(all.size()));
    set->grasps.push_back(*chosen);
    all.erase(chosen);
  }
  return set;
}

SceneObject box(const std::string& name, const std::array<double, 3>& size, const Pose& X_WO) {
  SceneObject object;
  object.name = name;
  object.geometry = BoxGeometry{size};
  object.shapes = {{Pose::Identity(), BoxShape{{size[0], size[1], size[2]}}}};
  object.X_WO = X_WO;
  return object;
}

Pose at(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

/// Where the box may stand so that the robot can hold it: by a random configuration and grasp. For
/// planar arms turned so that the box's edges are level, now and then.
Pose placeInReach(const SmallRobot& robot, const Pose& X_WB, const GraspSet& grasps, Draw& draw) {
  ArmVector q = draw.configuration(*robot.kinematics);
  if (robot.kind == RobotKind::kGantry && draw.chance(0.7)) q.tail(3).setZero();
  if (planar(robot.kind) && draw.chance(0.7)) {
    const Eigen::Index last = q.size() - 1;
    const double before = q[last - 1] + q[last - 2];
    q[last] = M_PI_2 * draw.below(4) - M_PI_2 - before;
    q[last] = std::clamp(std::remainder(q[last], 2 * M_PI), robot.kinematics->lower()[last],
                         robot.kinematics->upper()[last]);
  }
  const Pose X_WT = X_WB * robot.kinematics->toolPose(q);
  if (!planar(robot.kind)) {
    const Grasp& grasp =
        grasps.grasps[static_cast<std::size_t>(draw.below(static_cast<int>(grasps.grasps.size())))];
    return X_WT * grasp.X_OT.inverse();
  }
  // Only grasps that close across the plane are of use to a planar arm.
  std::vector<Pose> useful;
  for (const Grasp& grasp : grasps.grasps) {
    const Pose X_WO = X_WT * grasp.X_OT.inverse();
    if (std::abs(std::abs(X_WO.linear()(1, 1)) - 1) < 1e-9 &&
        std::abs(X_WO.translation().y() - kPlane) < 1e-9) {
      useful.push_back(X_WO);
    }
  }
  if (useful.empty()) return X_WT;
  return useful[static_cast<std::size_t>(draw.below(static_cast<int>(useful.size())))];
}

/// A board under a box whose edges are level, `gap` [m] below it; nothing else.
std::optional<SceneObject> boardUnder(const std::string& name, const std::array<double, 3>& size,
                                      const Pose& X_WO, double gap) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(std::abs(X_WO.linear()(2, axis)) - 1) > 1e-12) continue;
    const double bottom =
        X_WO.translation().z() - 0.5 * size[static_cast<std::size_t>(axis)] - 0.01 - gap;
    return box(name, {0.16, 0.16, 0.02},
               at(X_WO.translation().x(), X_WO.translation().y(), bottom));
  }
  return std::nullopt;
}

/// Takes out posts that are in boards, bases or other posts.
void dropPostsInside(Scene& scene) {
  Scene bare = scene;  // robots as they are built, but for their bases
  for (SceneRobot& robot : bare.robots) {
    robot.q_start = RobotVector::Zero(robot.model->dofs());
  }
  for (std::size_t i = 0; i < scene.objects.size();) {
    bare.objects = scene.objects;
    const auto bodies = std::make_shared<const CollisionScene>(bare);
    CollisionWorld world(bodies);
    const BodyId post = bodies->objectBody(ObjectId(i));
    const auto inside = [&](BodyId other) {
      return world.distance(post, other, 0.003).has_value();
    };
    bool hit = false;
    for (std::size_t other = 0; other < scene.objects.size(); ++other) {
      if (other != i && scene.objects[other].name != "box") {
        hit = hit || inside(bodies->objectBody(ObjectId(other)));
      }
    }
    for (const RobotId robot : IdRange<RobotId>(scene.robots.size())) {
      hit = hit || inside(bodies->linkBody(robot, LinkId(0)));
    }
    if (hit && scene.objects[i].name.starts_with("post")) {
      scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

/// A posture of the arm in which the robot touches nothing of the scene, if a few draws find one.
void standFree(Scene& scene, std::size_t robot, const SmallRobot& small, Draw& draw) {
  SceneRobot& placed = scene.robots[robot];
  for (int tries = 0; tries < 30; ++tries) {
    placed.q_start = RobotVector::Zero(small.model->dofs());
    const ArmVector q = draw.configuration(*small.kinematics);
    const Arm& arm = small.model->arms.front();
    for (std::size_t i = 0; i < arm.dofs.size(); ++i) {
      placed.q_start[arm.dofs[i].value()] = q[static_cast<Eigen::Index>(i)];
    }
    placed.q_start[small.model->hands.front().dofs.front().value()] = Gripper::kWidestOpening;
    const auto collision = std::make_shared<const CollisionScene>(scene);
    std::vector<DofId> dofs;
    for (const DofId dof : IdRange<DofId>(small.model->dofs())) dofs.push_back(dof);
    CollisionWorld world(collision);
    StateChecker checker(world, StateCheckerSetup(*collision, RobotId(robot), std::move(dofs)));
    if (checker.valid(placed.q_start)) return;
  }
}

}  // namespace

std::ostream& operator<<(std::ostream& out, const CellDraw& draw) {
  static constexpr std::array kNames{"planar", "sliding", "gantry", "seven"};
  return out << kNames[static_cast<std::size_t>(draw.giver)] << draw.giver_size << " -> "
             << kNames[static_cast<std::size_t>(draw.receiver)] << draw.receiver_size << ", "
             << draw.grasps << " grasps, " << draw.obstacles << " obstacles"
             << (draw.far ? ", far" : "") << ", seed " << draw.seed << (draw.hold ? ", hold" : "")
             << (draw.loose ? ", loose" : "");
}

rc::Gen<CellDraw> anyCell() {
  // At full size from the first draw on: rapidcheck's own ranges start with their smallest values.
  return rc::gen::resize(rc::kNominalSize, rc::gen::exec([] {
                           CellDraw draw;
                           // Planar arms need a planar partner: their tools meet in one plane only.
                           const bool flat = *rc::gen::arbitrary<bool>();
                           const int first = flat ? 0 : 2;
                           draw.giver = static_cast<RobotKind>(*rc::gen::inRange(first, first + 2));
                           draw.receiver =
                               static_cast<RobotKind>(*rc::gen::inRange(first, first + 2));
                           draw.giver_size = *rc::gen::inRange(0, SmallRobots::kPerKind);
                           draw.receiver_size = *rc::gen::inRange(0, SmallRobots::kPerKind);
                           draw.grasps = *rc::gen::inRange(3, flat ? 25 : 13);
                           draw.obstacles = *rc::gen::inRange(0, 3);
                           draw.far = *rc::gen::inRange(0, 5) == 4;
                           draw.seed = *rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>());
                           draw.hold = *rc::gen::inRange(0, 4) == 3;
                           draw.loose = *rc::gen::inRange(0, 8) == 7;
                           return draw;
                         }));
}

RandomCell makeCell(const SmallRobots& robots, const CellDraw& drawn) {
  Draw draw(drawn.seed);
  RandomCell cell;
  cell.giver = &robots.get(drawn.giver, drawn.giver_size);
  cell.receiver = &robots.get(drawn.receiver, drawn.receiver_size);
  const bool flat = planar(drawn.giver);
  auto scene = std::make_shared<Scene>();
  scene->cell = "random";
  scene->revision = 1;

  // Face to face across the origin.
  const double apart = (cell.giver->kinematics->reach() + cell.receiver->kinematics->reach()) *
                       draw.between(0.25, 0.75);
  SceneRobot giver, receiver;
  giver.name = "g";
  giver.model = cell.giver->model;
  giver.X_WB = at(-0.5 * apart, kPlane, 0.5 + draw.between(-0.15, 0.15));
  receiver.name = "r";
  receiver.model = cell.receiver->model;
  receiver.X_WB = at(0.5 * apart, kPlane, 0.5 + draw.between(-0.15, 0.15)) *
                  Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ());
  if (!flat) receiver.X_WB = receiver.X_WB * at(0, draw.between(-0.1, 0.1), 0);

  std::array<double, 3> size{draw.between(0.025, 0.06), draw.between(0.025, 0.06),
                             draw.between(0.08, 0.24)};
  const auto grasps_g = boxGrasps(size, drawn.grasps, draw);
  const auto grasps_r = boxGrasps(size, drawn.grasps, draw);
  SceneTask& task = cell.problem.task;
  task.name = "give";
  task.object = "box";
  task.chain = {{RobotId(0), {}}, {RobotId(1), {}}};
  if (drawn.hold) task.end = TransportEnd::kHold;
  task.X_WO_start = placeInReach(*cell.giver, giver.X_WB, *grasps_g, draw);
  task.X_WO_goal = placeInReach(*cell.receiver, receiver.X_WB, *grasps_r, draw);
  if (drawn.far) {
    Pose& X_WO = draw.chance(0.5) ? task.X_WO_start : task.X_WO_goal;
    X_WO.translation() += Eigen::Vector3d(
        draw.between(-0.6, 0.6), flat ? 0 : draw.between(-0.6, 0.6), draw.between(-0.6, 0.6));
  }

  // It stands on a board, or hangs.
  std::vector<SceneObject> others;
  Draw gaps(drawn.seed + 1);
  const auto rest = [&](const std::string& name, const Pose& X_WO) -> TaskRest {
    const double gap = drawn.loose ? gaps.between(0, 0.006) : 0;
    if (draw.chance(0.5)) {
      if (auto board = boardUnder(name, size, X_WO, gap)) {
        others.push_back(std::move(*board));
        return {false, std::vector<std::string>{name}};
      }
    }
    return {true, std::nullopt};
  };
  task.start_rest = rest("table", task.X_WO_start);
  task.goal_rest = rest("shelf", task.X_WO_goal);
  scene->objects.push_back(box("box", size, task.X_WO_start));
  scene->objects.insert(scene->objects.end(), others.begin(), others.end());
  for (int i = 0; i < drawn.obstacles; ++i) {
    const Pose X_WO = at(draw.between(-0.8, 0.8), kPlane + (flat ? 0 : draw.between(-0.4, 0.4)),
                         draw.between(0, 1.2));
    const std::array<double, 3> edges{draw.between(0.02, 0.15), draw.between(0.02, 0.15),
                                      draw.between(0.02, 0.3)};
    scene->objects.push_back(box("post" + std::to_string(i), edges, X_WO));
  }
  scene->robots = {giver, receiver};
  if (!drawn.loose) dropPostsInside(*scene);
  for (SceneRobot& robot : scene->robots) robot.q_start = RobotVector::Zero(robot.model->dofs());
  // The receiver may have to stand clear of the giver: it is drawn last.
  standFree(*scene, 0, *cell.giver, draw);
  standFree(*scene, 1, *cell.receiver, draw);

  cell.problem.scene = startOf(scene, task);
  cell.problem.collision = collisionForTask(*cell.problem.scene, task.object);
  for (const auto& [robot, grasps] :
       {std::pair(cell.giver, grasps_g), std::pair(cell.receiver, grasps_r)}) {
    RobotResources resources;
    resources.kinematics = {robot->kinematics};
    resources.maps = {robot->map};
    resources.grasps = {grasps};
    cell.problem.resources.push_back(std::move(resources));
  }
  return cell;
}

}  // namespace handover::test
