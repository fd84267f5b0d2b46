// SPDX-License-Identifier: Apache-2.0
// Where the object rests (design §5, Rest), on drawn heights and tilts about contact in every cell:
// no plan that is called done is refused by the verifier, and nothing is refused where the rule
// holds with 0.3 mm to spare, by FCL.
#include "cells/cell_service.hpp"
#include "support/fcl_shapes.hpp"
#include "support/property.hpp"
#include "support/recorder.hpp"
#include "support/verified.hpp"

#include <handover/common/random.hpp>

#include <gtest/gtest.h>

#include <map>

namespace handover::test {
namespace {

struct RestCell {
  const char* name;
  bool put_down;  // in the end
};

constexpr RestCell kCells[] = {{"butler", true},     {"butler_left", true}, {"stool", false},
                               {"kneeling", false},  {"relay", true},       {"hand_to_hand", true},
                               {"pick_place", true}, {"serve_person", true}};

CellService& service() {
  static CellService instance = [] {
    std::vector<std::string> names;
    for (const RestCell& cell : kCells) names.emplace_back(cell.name);
    return CellService(HANDOVER_SOURCE_DIR, names,
                       std::filesystem::path(HANDOVER_BINARY_DIR "/test-cache/handover"), {},
                       false);
  }();
  static const bool prepared = [] {
    instance.prepareAll(Deadline());
    return true;
  }();
  (void)prepared;
  return instance;
}

/// What of the scene O may rest on or be in, by FCL; robots left out.
class Surroundings {
 public:
  Surroundings(const Scene& scene, const std::string& object) {
    for (const SceneObject& it : scene.objects) {
      std::vector<FclShape> shapes;
      for (const Shape& shape : it.shapes) shapes.emplace_back(shape);
      if (it.name == object) {
        object_ = std::move(shapes);
      } else {
        others_.push_back({worldPose(scene, it), std::move(shapes)});
      }
    }
  }

  /// O, moved up by `up` [m], overlaps something.
  bool overlaps(Pose X_WO, double up) const {
    X_WO.translation().z() += up;
    for (const Other& other : others_) {
      for (const FclShape& a : object_) {
        for (const FclShape& b : other.shapes) {
          if (fclOverlap(a, X_WO, b, other.X_WB)) return true;
        }
      }
    }
    return false;
  }

 private:
  struct Other {
    Pose X_WB;
    std::vector<FclShape> shapes;
  };

  static Pose worldPose(const Scene& scene, const SceneObject& object) {
    if (!object.attached_to) return object.X_WO;
    const SceneRobot& robot = scene.robots[object.attached_to->robot];
    std::vector<Pose> X_WL;
    linkPoses(*robot.model, robot.X_WB, robot.q_start, X_WL);
    return X_WL[object.attached_to->link] * object.attached_to->X_LO;
  }

  std::vector<FclShape> object_;
  std::vector<Other> others_;
};

class RestProperty : public testing::TestWithParam<RestCell> {
 protected:
  PlanRequest request(std::uint64_t seed) const {
    PlanRequest request;
    request.id = RequestId::random();
    request.client_id = "test";
    request.cell = GetParam().name;
    request.mode = SearchMode::kFirst;
    request.seed = seed;
    request.wants_fix = false;
    return request;
  }

  TransportProblem problemOf(const PlanRequest& request) const {
    auto problem = service().problemOf(request, Deadline());
    return std::get<TransportProblem>(std::move(problem));
  }

  static Override poseOverride(const std::string& path, const Pose& X) {
    const auto number = [](double value) { return std::to_string(value); };
    const Eigen::Vector3d p = X.translation();
    const Eigen::Vector3d rpy = X.linear().eulerAngles(2, 1, 0) * (180 / M_PI);
    return {path, "{xyz: [" + number(p.x()) + ", " + number(p.y()) + ", " + number(p.z()) +
                      "], rpy_deg: [" + number(rpy[2]) + ", " + number(rpy[1]) + ", " +
                      number(rpy[0]) + "]}"};
  }

  /// Most are near enough to contact for the rule to be in doubt.
  static double height(SeededRandom& random) {
    return random.unit() < 0.5 ? random.uniform(-0.003, 0.003) : random.uniform(-0.02, 0.02);
  }

  void check(const PlanRequest& request, bool start) {
    const TransportProblem problem = problemOf(request);
    const Pose X_WO = start ? problem.task.X_WO_start : problem.task.X_WO_goal;
    Recorder recorder;
    const Outcome outcome = service().planAlone(request, recorder, Deadline());
    SCOPED_TRACE(request.overrides.front().path + "=" + request.overrides.front().value);
    if (std::holds_alternative<Done>(outcome)) {
      ++done;
      EXPECT_TRUE(verified(recorder.events, outcome, HANDOVER_SOURCE_DIR));
      return;
    }
    const auto* failed = std::get_if<Failed>(&outcome);
    ASSERT_NE(failed, nullptr);
    const auto refused = [&](FailureReason at_start, FailureReason at_goal) {
      return failed->reason == (start ? at_start : at_goal);
    };
    const Surroundings around(*problem.scene, problem.task.object);
    if (refused(FailureReason::kStartInCollision, FailureReason::kGoalInCollision)) {
      ++in_collision;
      if (namesRobot(*failed)) return;
      EXPECT_TRUE(around.overlaps(X_WO, 0.0007)) << failed->explanation.text;
    } else if (refused(FailureReason::kStartUnsupported, FailureReason::kGoalUnsupported)) {
      ++unsupported;
      EXPECT_FALSE(around.overlaps(X_WO, -0.0017)) << failed->explanation.text;
    } else {
      EXPECT_NE(failed->reason, FailureReason::kInternal) << failed->explanation.text;
    }
  }

  static bool namesRobot(const Failed& failed) {
    for (const CauseCount& cause : failed.explanation.causes) {
      if (cause.pair.first.find('/') != std::string::npos ||
          cause.pair.second.find('/') != std::string::npos) {
        return true;
      }
    }
    return false;
  }

  static int cases() { return propertyCases(3); }

  /// Few draws may miss one.
  void expectEveryVerdict() const {
    if (cases() < 40) return;
    EXPECT_GT(done, 0);
    EXPECT_GT(in_collision, 0);
    EXPECT_GT(unsupported, 0);
  }

  static std::string taskName() {
    for (const CellInfo& cell : service().served()->infos) {
      if (cell.name == GetParam().name) return cell.tasks.front();
    }
    return "";
  }

  int done = 0, in_collision = 0, unsupported = 0;
};

INSTANTIATE_TEST_SUITE_P(Cells, RestProperty, testing::ValuesIn(kCells),
                         [](const auto& cell) { return std::string(cell.param.name); });

TEST_P(RestProperty, OfStartsAboutContact) {
  const TransportProblem nominal = problemOf(request(1));
  SeededRandom random(SeededRandom::mix(41));
  for (int i = 0; i < cases(); ++i) {
    Pose X_WO = nominal.task.X_WO_start;
    X_WO.translation() +=
        Eigen::Vector3d(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), height(random));
    PlanRequest drawn = request(static_cast<std::uint64_t>(i + 1));
    drawn.overrides = {poseOverride("objects." + nominal.task.object + ".pose", X_WO)};
    check(drawn, true);
  }
  expectEveryVerdict();
}

TEST_P(RestProperty, OfGoalsAboutContact) {
  if (!GetParam().put_down) GTEST_SKIP() << "ends in the hand";
  const TransportProblem nominal = problemOf(request(1));
  SeededRandom random(SeededRandom::mix(42));
  for (int i = 0; i < cases(); ++i) {
    Pose X_WO = nominal.task.X_WO_goal;
    X_WO.translation() +=
        Eigen::Vector3d(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), height(random));
    PlanRequest drawn = request(static_cast<std::uint64_t>(i + 1));
    drawn.overrides = {poseOverride("tasks." + taskName() + ".goal", X_WO)};
    check(drawn, false);
  }
  expectEveryVerdict();
}

}  // namespace
}  // namespace handover::test
