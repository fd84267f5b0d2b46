// SPDX-License-Identifier: Apache-2.0
#include "core/planning/scene_validity.hpp"

#include "core/grasp/object_surface.hpp"
#include "core/planning/cause_tally.hpp"
#include "core/planning/explanation.hpp"
#include "core/planning/manipulator.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>

namespace handover {
namespace {

// Of the contract's 1 mm up and 2 mm down.
constexpr double kRaised = 0.0008;
constexpr double kLowered = 0.0018;
constexpr double kLookDown = 0.3;  // for the gap that is told [m]
constexpr double kNearFixture = 0.002;
constexpr double kApart = 1e-5;  // beyond a depth, to be out [m]
constexpr double kFlush = 1e-6;  // what rounding presses faces into each other [m]

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f mm", 1e3 * metres);
  return text;
}

class SceneChecker {
 public:
  SceneChecker(const TransportProblem& problem, CollisionWorld& world)
      : problem_(problem),
        scene_(*problem.scene),
        bodies_(*problem.collision),
        world_(world),
        object_(bodies_.objectBody(scene_.findObject(problem.task.object))) {}

  /// Everything against everything else, O apart: with margins where something moves.
  std::optional<Failed> checkStanding() {
    std::vector<BodyId> bodies;
    std::vector<bool> moves(static_cast<std::size_t>(bodies_.bodies()));
    for (const RobotId robot : IdRange<RobotId>(scene_.robots.size())) {
      addMoving(robot, bodies);
    }
    for (const BodyId body : bodies) moves[body] = true;
    for (const BodyId body : IdRange<BodyId>(bodies_.bodies())) {
      if (!moves[body] && body != object_) bodies.push_back(body);
    }
    BodyPairs allowed(bodies_.bodies());
    for (const BodyId body : bodies) allowed.insert(body, object_);
    world_.reset();
    world_.setPose(object_, problem_.task.X_WO_start);
    auto contacts = world_.contacts(world_.makePairs(bodies, allowed));
    std::erase_if(contacts, [&](const BodyContact& contact) {
      return !moves[contact.a] && !moves[contact.b] &&
             (contact.depth <= kFlush || !trulyOverlap(contact));
    });
    return failureOf(contacts, FailureReason::kStartInCollision, "start", "At the start");
  }

  /// O in the hand that holds it, against everything but that hand; a hand that cannot have it.
  std::optional<Failed> checkHeld(const ChainHolder& holder) {
    if (const auto unfit = unfitReason(problem_, holder.robot, holder.arm)) {
      return explainUnfitHolder(problem_, holder, *unfit);
    }
    BodyPairs allowed(bodies_.bodies());
    const Manipulator arm = makeManipulator(problem_, holder.robot, holder.arm);
    allowed.insert(arm.hand_bodies, {object_});
    return failureOf(contactsAt(problem_.task.X_WO_start, allowed),
                     FailureReason::kStartInCollision, "start", "At the start");
  }

  /// O where a hand is to hold it in the end, against all but arms, which can move away.
  std::optional<Failed> checkHeldGoal() {
    BodyPairs allowed(bodies_.bodies());
    for (const RobotId robot : IdRange<RobotId>(scene_.robots.size())) {
      const RobotModel& model = *scene_.robots[robot].model;
      for (const ArmId arm : IdRange<ArmId>(model.arms.size())) {
        if (unfitReason(problem_, robot, arm)) continue;
        const auto& dofs = model.arms[arm].dofs;
        allowed.insert(bodies_.linkBodies(robot, model.linksMovedBy(dofs)), {object_});
      }
    }
    const auto contacts = contactsAt(problem_.task.X_WO_goal, allowed);
    const auto inside = overlapping(contacts);
    if (!inside.empty()) {
      return failureOf(inside, FailureReason::kGoalInCollision, "goal", "At its goal");
    }
    // It would be free there, but motions keep margins.
    auto failed = failureOf(contacts, FailureReason::kNoPath, "goal", "Where it is to be held");
    if (failed) failed->explanation.exhaustive = false;
    return failed;
  }

  struct Place {
    FailureReason in_collision, unsupported;
    const char* filter;
    const char* text;
  };

  /// O put down, the robots as at the start.
  std::optional<Failed> checkRest(const Pose& X_WO, TaskRest& rest, const Place& place) {
    const BodyPairs none(bodies_.bodies());
    const auto above = trulyOverlapping(contactsAt(moved(X_WO, kRaised), none));
    if (!above.empty()) return inCollision(asDeepAs(X_WO, above), X_WO, place);
    if (rest.none) {
      rest.objects = near(X_WO);
      return std::nullopt;
    }
    std::vector<std::string> below;
    for (const BodyContact& contact : trulyOverlapping(contactsAt(moved(X_WO, -kLowered), none))) {
      const BodyId other = contact.a == object_ ? contact.b : contact.a;
      if (!bodies_.robotOf(other).valid()) below.push_back(bodies_.name(other));
    }
    std::sort(below.begin(), below.end());
    if (!rest.objects) rest.objects = below;
    const bool rests = std::any_of(rest.objects->begin(), rest.objects->end(), [&](const auto& it) {
      return std::binary_search(below.begin(), below.end(), it);
    });
    if (rests) return std::nullopt;
    return unsupported(X_WO, rest, place);
  }

 private:
  void addMoving(RobotId robot, std::vector<BodyId>& moving) const {
    const RobotModel& model = *scene_.robots[robot].model;
    std::vector<DofId> dofs;
    for (const Arm& arm : model.arms) dofs.insert(dofs.end(), arm.dofs.begin(), arm.dofs.end());
    for (const Hand& hand : model.hands) {
      dofs.insert(dofs.end(), hand.dofs.begin(), hand.dofs.end());
    }
    for (const BodyId body : bodies_.linkBodies(robot, model.linksMovedBy(dofs))) {
      moving.push_back(body);
    }
  }

  static Pose moved(const Pose& X_WO, double up) { return Eigen::Translation3d(0, 0, up) * X_WO; }

  std::vector<BodyContact> contactsAt(const Pose& X_WO, const BodyPairs& allowed) {
    world_.reset();
    world_.setPose(object_, X_WO);
    return world_.contacts(world_.makePairs({object_}, allowed));
  }

  /// Without those that only margins make.
  static std::vector<BodyContact> overlapping(std::vector<BodyContact> contacts) {
    std::erase_if(contacts, [](const BodyContact& contact) { return contact.depth <= 0; });
    return contacts;
  }

  /// Contacts found a little above, as deep as they are where O is.
  std::vector<BodyContact> asDeepAs(const Pose& X_WO, std::vector<BodyContact> contacts) {
    const BodyPairs none(bodies_.bodies());
    for (const BodyContact& here : contactsAt(X_WO, none)) {
      for (BodyContact& contact : contacts) {
        if (contact.a == here.a && contact.b == here.b) contact = here;
      }
    }
    return contacts;
  }

  /// How far O has to go up to be free [m], at most kLookDown; nullopt: farther.
  std::optional<double> depthBelow(const Pose& X_WO) {
    const BodyPairs none(bodies_.bodies());
    const auto free = [&](double up) {
      return trulyOverlapping(contactsAt(moved(X_WO, up), none)).empty();
    };
    double within = 0, out = kRaised;
    while (out < kLookDown && !free(out)) within = out, out *= 2;
    if (!free(out)) return std::nullopt;
    while (out - within > 1e-5) {
      const double middle = 0.5 * (within + out);
      (free(middle) ? out : within) = middle;
    }
    return out;
  }

  /// Whether the least move that parts those convex parts that are deepest in each other parts the
  /// bodies: where others stay in each other, these are deeper than `contact` says.
  bool parted(const BodyContact& contact, const Pose& X_WO) {
    const BodyId other = contact.a == object_ ? contact.b : contact.a;
    world_.setPose(object_, X_WO);
    const auto deepest = world_.distance(object_, other, 0);
    if (!deepest) return true;
    const Eigen::Vector3d way = (contact.depth + kApart) * deepest->n_W;
    world_.setPose(object_, Eigen::Translation3d(way) * X_WO);
    return !world_.distance(object_, other, 0);
  }

  /// O in what it should stand on, or in something else.
  Failed inCollision(std::vector<BodyContact> contacts, const Pose& X_WO, const Place& place) {
    const auto up = depthBelow(X_WO);
    BodyContact& first = contacts.front();
    if (up && contacts.size() == 1 && *up > first.depth && !parted(first, X_WO)) first.depth = *up;
    Failed failed = *failureOf(contacts, place.in_collision, place.filter, place.text);
    if (up) {
      failed.explanation.text.pop_back();
      failed.explanation.text += "; " + millimetres(*up) + " higher it is free.";
    }
    return failed;
  }

  /// Of bodies whose parts overlap: where parts only approach a surface, the surfaces tell.
  bool trulyOverlap(const BodyContact& contact) {
    if (!dividedOf(contact.a) && !dividedOf(contact.b)) return true;
    return intersect(surfaceOf(contact.a), world_.pose(contact.a), surfaceOf(contact.b),
                     world_.pose(contact.b));
  }

  /// Everything stands where the contacts were found.
  std::vector<BodyContact> trulyOverlapping(std::vector<BodyContact> contacts) {
    contacts = overlapping(std::move(contacts));
    std::erase_if(contacts, [&](const BodyContact& contact) { return !trulyOverlap(contact); });
    return contacts;
  }

  /// As world_.distance(), of the surfaces themselves.
  std::optional<double> distance(BodyId a, BodyId b, double max) {
    const auto parts = world_.distance(a, b, max);
    if (!parts) return std::nullopt;
    if (!dividedOf(a) && !dividedOf(b)) return parts->distance;
    const ObjectSurface &of_a = surfaceOf(a), &of_b = surfaceOf(b);
    if (intersect(of_a, world_.pose(a), of_b, world_.pose(b))) return 0;
    const auto found =
        SurfaceTree::distance(of_a.tree(), world_.pose(a), of_b.tree(), world_.pose(b), max);
    return found ? std::optional(found->distance) : std::nullopt;
  }

  struct Made {
    const std::vector<Shape>& shapes;
    const std::shared_ptr<const DividedBodies>& divided;
  };

  Made madeOf(BodyId body) const {
    const RobotId robot = bodies_.robotOf(body);
    if (!robot.valid()) {
      for (const ObjectId o : IdRange<ObjectId>(scene_.objects.size())) {
        const SceneObject& object = scene_.objects[o];
        if (bodies_.objectBody(o) == body) return {object.shapes, object.divided};
      }
    }
    const auto& links = scene_.robots[robot].model->links;
    LinkId link(0);
    while (bodies_.linkBody(robot, link) != body) ++link;
    return {links[link].collision, links[link].divided};
  }

  bool dividedOf(BodyId body) const { return madeOf(body).divided != nullptr; }

  const ObjectSurface& surfaceOf(BodyId body) {
    const auto known = surfaces_.find(body);
    if (known != surfaces_.end()) return known->second;
    const Made made = madeOf(body);
    return surfaces_.emplace(body, ObjectSurface(made.shapes, made.divided)).first->second;
  }

  std::vector<std::string> near(const Pose& X_WO) {
    world_.reset();
    world_.setPose(object_, X_WO);
    std::vector<std::string> names;
    for (const SceneObject& object : scene_.objects) {
      const BodyId body = bodies_.objectBody(scene_.findObject(object.name));
      if (body != object_ && distance(object_, body, kNearFixture)) {
        names.push_back(object.name);
      }
    }
    return names;
  }

  std::optional<Failed> failureOf(const std::vector<BodyContact>& contacts, FailureReason reason,
                                  const char* filter, const std::string& text) const {
    if (contacts.empty()) return std::nullopt;
    CauseTally hits;
    for (const BodyContact& contact : contacts) {
      hits.add(Cause::kCollision, {bodies_.name(contact.a), bodies_.name(contact.b)});
    }
    const BodyContact& first = contacts.front();
    const std::string& a = bodies_.name(first.a);
    const std::string& b = bodies_.name(first.b);
    const std::string what =
        first.depth > 0
            ? a + " is inside " + b + " by " + millimetres(first.depth)
            : a + " is " + millimetres(-first.depth) + " from " + b + ", within its margin";
    return failed(reason, filter, text + " " + what + ".", hits.counts(), true);
  }

  std::optional<Failed> unsupported(const Pose& X_WO, const TaskRest& rest, const Place& place) {
    double gap = kLookDown;
    std::string nearest;
    world_.reset();
    world_.setPose(object_, X_WO);
    for (const SceneObject& object : scene_.objects) {
      const BodyId body = bodies_.objectBody(scene_.findObject(object.name));
      const bool wanted =
          rest.objects->empty() ||
          std::find(rest.objects->begin(), rest.objects->end(), object.name) != rest.objects->end();
      if (body == object_ || !wanted) continue;
      const auto away = distance(object_, body, gap);
      if (!away || *away >= gap) continue;
      gap = *away;
      nearest = object.name;
    }
    const std::string& name = problem_.task.object;
    std::string text = std::string(place.text) + " " + name + " rests on nothing";
    CauseTally causes;
    if (nearest.empty()) {
      text += " within 30 cm.";
      causes.add(Cause::kUnsupported, {name, {}});
    } else {
      text += "; " + nearest + " is " + millimetres(std::max(gap, 0.0)) + " away.";
      causes.add(Cause::kUnsupported, {name, nearest});
    }
    return failed(place.unsupported, place.filter, text, causes.counts(), true);
  }

  const TransportProblem& problem_;
  const Scene& scene_;
  const CollisionScene& bodies_;
  CollisionWorld& world_;
  const BodyId object_;
  std::map<BodyId, ObjectSurface> surfaces_;  ///< made where they are asked for
};

}  // namespace

namespace {

std::optional<Failed> checkStart(SceneChecker& checker, SceneTask& task) {
  if (task.held_by) {
    task.start_rest = {false, std::vector<std::string>()};
    return checker.checkHeld(*task.held_by);
  }
  return checker.checkRest(task.X_WO_start, task.start_rest,
                           {FailureReason::kStartInCollision, FailureReason::kStartUnsupported,
                            "start", "At the start"});
}

/// Two failures of one reason as one, sums of other pairs still last.
Failed both(Failed a, const Failed& b) {
  a.explanation.text += " " + b.explanation.text;
  std::vector<CauseCount>& causes = a.explanation.causes;
  causes.insert(causes.end(), b.explanation.causes.begin(), b.explanation.causes.end());
  std::stable_partition(causes.begin(), causes.end(),
                        [](const CauseCount& cause) { return !cause.pair.first.empty(); });
  return a;
}

/// All that stands, and O at its start.
std::optional<Failed> checkFirst(SceneChecker& checker, SceneTask& task) {
  auto standing = checker.checkStanding();
  auto start = checkStart(checker, task);
  if (standing && start && start->reason == standing->reason) return both(*standing, *start);
  return standing ? standing : start;
}

std::optional<Failed> checkGoal(SceneChecker& checker, SceneTask& task) {
  const bool hold = task.end == TransportEnd::kHold;
  if (hold) task.goal_rest = {false, std::vector<std::string>()};
  auto failed = hold ? checker.checkHeldGoal()
                     : checker.checkRest(task.X_WO_goal, task.goal_rest,
                                         {FailureReason::kGoalInCollision,
                                          FailureReason::kGoalUnsupported, "goal", "At its goal"});
  if (failed) {
    const auto last = static_cast<std::uint32_t>(task.chain.empty() ? 0 : task.chain.size() - 1);
    const StageAction end = hold ? StageAction::kCarry : StageAction::kPlace;
    failed->explanation.farthest = Farthest{toValue(task.X_WO_goal), {}, {last, end}};
  }
  return failed;
}

}  // namespace

std::optional<Failed> checkScene(const TransportProblem& problem, CollisionWorld& world,
                                 SceneTask& task) {
  SceneChecker checker(problem, world);
  if (auto failed = checkFirst(checker, task)) return failed;
  return checkGoal(checker, task);
}

std::optional<Failed> checkBodies(const TransportProblem& problem, CollisionWorld& world,
                                  SceneTask& task) {
  SceneChecker checker(problem, world);
  if (auto failed = checkFirst(checker, task)) return failed;
  return task.end == TransportEnd::kHold ? std::nullopt : checkGoal(checker, task);
}

std::vector<Failed> sceneFaults(const TransportProblem& problem, CollisionWorld& world) {
  SceneChecker checker(problem, world);
  SceneTask task = problem.task;
  std::vector<Failed> faults;
  for (auto& fault :
       {checker.checkStanding(), checkStart(checker, task), checkGoal(checker, task)}) {
    if (fault) faults.push_back(*fault);
  }
  return faults;
}

}  // namespace handover
