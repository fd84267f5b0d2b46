// SPDX-License-Identifier: Apache-2.0
// Pages and recordings of plan files, in a real browser and by Foxglove's decoder.
#include "view/view.hpp"

#include "process.hpp"
#include "sample_plan.hpp"
#include "view/page.hpp"

#include <handover/client/plan_file.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace handover::view::test {
namespace {

using handover::test::Finished;
using testing::AllOf;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using namespace std::chrono_literals;

class View : public testing::Test {
 protected:
  std::string view(const Json& plan, const std::string& output = "plan.html") const {
    return planView(plan.dump(), output, cell_.root());
  }

  std::string faultOf(const Json& plan, const std::string& output = "plan.html") const {
    try {
      view(plan, output);
    } catch (const client::PlanFileError& error) {
      return error.what();
    }
    return "";
  }

  std::string write(const Json& plan, const std::string& output = "plan.html") const {
    return cell_.write(output, view(plan, output)).string();
  }

  /// What the browser sees of a page at these times, on a screen and on a phone.
  Json browse(const Json& plan, const std::vector<double>& times = {}) const {
    return browsePage(write(plan), times);
  }

  Json browsePage(const std::string& page, const std::vector<double>& times) const {
    std::vector<std::string> command{NODE, BROWSE, page, "1280x800,390x844"};
    for (const double time : times) command.push_back(std::to_string(time));
    const Finished browsed = handover::test::run(command, {}, 240s);
    EXPECT_EQ(browsed.status, 0) << browsed.err;
    return Json::parse(browsed.out);
  }

  /// Of the sample plan at the times below: looked at once.
  const Json& seenPlan() const {
    static const Json seen = browse(cell_.plan(), timesOf(cell_.plan()));
    return seen;
  }

  const Json& seenFailure() const {
    static const Json seen = browse(cell_.failure());
    return seen;
  }

  static constexpr double kInReach = 0.3, kInCarry = 0.7, kInLastCarry = 1.1;  // [s] of the stage

  /// In the first reach, the first and the last carry, and after all is done.
  static std::vector<double> timesOf(const Json& plan) {
    const auto in = [&](int holder, const std::string& action, double s) {
      return stageOf(plan, holder, action)["start"].get<double>() + s;
    };
    return {in(0, "reach", kInReach), in(0, "carry", kInCarry), in(2, "carry", kInLastCarry),
            endOf(stageOf(plan, 2, "release")) + 1};
  }

  const SampleCell cell_;
};

TEST_F(View, WritesOnePageThatReachesForNothingOutside) {
  const std::string page = view(cell_.plan());
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, Not(HasSubstr("unsafe-inline")));
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link ")));
  EXPECT_THAT(page, HasSubstr("\"robots/duo/meshes/palm.obj\""));
}

TEST_F(View, KeepsMarkupInNamesOutOfThePage) {
  Json plan = cell_.plan();
  plan["scene"]["task"] = "</script><script>alert(1)</script>";
  const std::string page = view(plan);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cscript>alert(1)"));
}

TEST_F(View, SaysWhatItCannotRead) {
  EXPECT_THAT(faultOf({{"format", "handover-plan/1"}}), HasSubstr("/format"));
  EXPECT_THROW(planView("{", "plan.html", cell_.root()), client::PlanFileError);

  Json plan = cell_.plan();
  plan["scene"]["robots"][0]["urdf"] = "robots/none.urdf";
  EXPECT_THAT(faultOf(plan), HasSubstr("robots/none.urdf: no such file"));
  EXPECT_THAT(faultOf(plan, "plan.mcap"), HasSubstr("robots/none.urdf: no such file"));

  plan = cell_.plan();
  plan["scene"].erase("objects");
  EXPECT_THAT(faultOf(plan), HasSubstr("objects"));

  plan = cell_.plan();
  plan["plan"]["stages"][3]["qdd"].erase(0);
  EXPECT_THAT(faultOf(plan, "plan.mcap"), HasSubstr("/plan/stages"));

  EXPECT_THAT(faultOf(cell_.failure(), "plan.mcap"), HasSubstr("/plan: is null"));
}

TEST_F(View, SaysWhichCollisionMeshIsMissing) {
  std::filesystem::remove(cell_.root() / "robots/duo/meshes/palm.obj");
  EXPECT_THAT(faultOf(cell_.plan()),
              AllOf(HasSubstr("robots/duo/duo.urdf"), HasSubstr("meshes/palm.obj")));
  EXPECT_THAT(faultOf(cell_.plan(), "plan.mcap"), HasSubstr("meshes/palm.obj"));
}

TEST_F(View, FindsMeshesOfPackagesAndForgivesFilesThatAreNotUtf8) {
  std::string urdf = handover::test::textOf(cell_.root() / "robots/duo/duo.urdf");
  const std::string name = "meshes/palm.obj";
  for (std::size_t at = 0; (at = urdf.find(name, at)) != std::string::npos; at += 20) {
    urdf.insert(at, "package://duo/");
  }
  cell_.write("robots/duo/duo.urdf", urdf);
  const auto mesh = cell_.root() / "robots/duo" / name;
  cell_.write("robots/duo/" + name, "# caf\xe9\n" + handover::test::textOf(mesh));
  EXPECT_THAT(view(cell_.plan()), HasSubstr("caf\xef\xbf\xbd"));
}

void expectPoint(const Json& seen, const std::vector<double>& expected, double within) {
  ASSERT_EQ(seen.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(seen[k].get<double>(), expected[k], within) << k << " of " << seen;
  }
}

double smooth(double s) { return s * s * s * (10 + s * (-15 + 6 * s)); }

TEST_F(View, PageRunsInABrowser) {
  const Json& seen = seenPlan();
  EXPECT_EQ(seen["error"], "");
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_THAT(seen["requests"], IsEmpty());
  EXPECT_EQ(seen["title"], "sample: duo/left gives box to duo/right, duo/right to crane/arm");
  EXPECT_EQ(seen["failed_parts"], 0);
  EXPECT_EQ(seen["names"], (Json{"duo/left", "duo/right", "crane/arm"}));
  EXPECT_EQ(seen["cameras"], (Json{"cell", "start", "handover 1", "handover 2", "goal", "object"}));
  EXPECT_EQ(seen["time_after_click"]["half"], seen["time_after_click"]["time"]);
  EXPECT_GT(seen["time_after_play"], seen["time_after_click"]["time"]);
  EXPECT_NEAR(seen["time_after_key"].get<double>(), seen["duration"].get<double>(), 1e-9);
  EXPECT_GT(seen["colours"], 100) << "the picture is blank";
}

TEST_F(View, BarsStandWhereTheirStagesRun) {
  const Json plan = cell_.plan();
  const Json& seen = seenPlan();
  const Json& bars = seen["bars"];
  const Json& stages = plan["plan"]["stages"];
  ASSERT_EQ(bars.size(), stages.size());
  const double left = seen["time_line"]["left"], right = seen["time_line"]["right"];
  const double scale = (right - left) / seen["duration"].get<double>();
  std::vector<std::vector<double>> rows(3);
  for (const Json& bar : bars) {
    const Json& stage = stages[bar["stage"].get<std::size_t>()];
    EXPECT_NEAR(bar["left"].get<double>(), left + scale * stage["start"].get<double>(), 1.5);
    EXPECT_NEAR(bar["right"].get<double>(), left + scale * endOf(stage), 1.5);
    rows[stage["holder"].get<std::size_t>()].push_back(bar["top"]);
  }
  for (const auto& row : rows) EXPECT_THAT(row, testing::Each(row.front()));
  EXPECT_LT(rows[0].front(), rows[1].front());
  EXPECT_LT(rows[1].front(), rows[2].front());
  EXPECT_THAT(bars[0]["title"].get<std::string>(), HasSubstr("duo/left reach: 0.00 s, 1.00 s"));
}

TEST_F(View, NothingOverlapsNorStandsOutOnAScreenOrAPhone) {
  for (const Json& seen : {seenPlan(), seenFailure()}) {
    ASSERT_EQ(seen["misplaced"].size(), 2u);
    for (const Json& on : seen["misplaced"]) {
      EXPECT_THAT(on["overlaps"], IsEmpty()) << on["width"];
      EXPECT_THAT(on["outside"], IsEmpty()) << on["width"];
    }
  }
}

TEST_F(View, PageMovesJointsAlongQuinticsAndTheObjectWithItsHolder) {
  const Json& at = seenPlan()["at"];
  ASSERT_EQ(at.size(), 4u);

  // The finger opens in the reach: between two samples the curve is that of the whole stage.
  const double opened = 0.01 + 0.03 * smooth(kInReach / 1.0);
  EXPECT_NEAR(at[0]["joints"]["duo"]["l_left"].get<double>(), opened, 1e-6);
  EXPECT_NEAR(at[0]["joints"]["duo"]["l_right"].get<double>(), opened, 1e-6);  // mimics
  expectPoint(at[0]["object"], {-0.4, 0, 0.06}, 1e-9);
  EXPECT_EQ(at[0]["stage"], "duo/left reach");
  EXPECT_THAT(at[0]["text"].get<std::string>(), HasSubstr("nobody holds the box"));

  const double s = smooth(kInCarry / 1.6);
  expectPoint(at[1]["object"], {-0.4 + 0.3 * s, 0, 0.11 + 0.29 * s}, 1e-6);
  EXPECT_THAT(at[1]["text"].get<std::string>(), HasSubstr("duo/left holding the box"));

  const double u = smooth(kInLastCarry / 2.0);
  expectPoint(at[2]["object"], {0.1 + 0.3 * u, 0.2 * u, 0.4 - 0.24 * u}, 1e-6);
  EXPECT_THAT(at[2]["text"].get<std::string>(), HasSubstr("crane/arm holding the box"));

  expectPoint(at[3]["object"], {0.4, 0.2, 0.06}, 1e-6);  // where it was put down
}

TEST_F(View, FailurePageSaysWhyAndWhatWouldHelp) {
  const Json& seen = seenFailure();
  EXPECT_EQ(seen["error"], "");
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_EQ(seen["title"], "sample: no plan for box");
  EXPECT_EQ(seen["planned_parts"], 0);
  EXPECT_GT(seen["failed_parts"], 0);
  const std::string text = seen["text"];
  EXPECT_THAT(text, HasSubstr("no handover pose"));
  EXPECT_THAT(text, HasSubstr("At none of 412 poses"));
  EXPECT_THAT(text, HasSubstr("Everything within what the search covers was tried."));
  EXPECT_THAT(text, HasSubstr("crane/cup – table"));
  EXPECT_THAT(text, HasSubstr("311 ×"));
  EXPECT_THAT(text, HasSubstr("--set 'robots.crane.base.xyz=[0.3, 0.7, 0]'"));
  EXPECT_THAT(text, HasSubstr("With crane 10 cm nearer there is a plan."));
  EXPECT_THAT(text, HasSubstr("duo/left and crane/arm: approach of holder 2"));
  EXPECT_EQ(seen["failure"]["copied"], "--set 'robots.crane.base.xyz=[0.3, 0.7, 0]'");
  EXPECT_EQ(seen["cameras"], (Json{"cell", "start", "farthest", "goal"}));
  EXPECT_GT(seen["red"], 0) << "the bodies that touch are not red";
  EXPECT_GT(seen["colours"], 100) << "the picture is blank";
}

TEST_F(View, FailurePageHasABarForEachFilterAndMarksTheOneThatEmptied) {
  EXPECT_EQ(seenFailure()["failure"]["funnel"],
            Json::parse(R"([["", "start and goal free", "", "2 of 2"],
                            ["", "arms for the start", "", "1 of 2"],
                            ["", "arms for the goal", "", "1 of 1"],
                            ["", "grasps at the start", "", "12 of 40"],
                            ["", "grasps at the goal", "", "9 of 36"],
                            ["", "points both reach", "", "12"],
                            ["ended", "handover poses", "", "0 of 412"],
                            ["", "poses with both grasps", "", "0"],
                            ["unreached", "motions", "", "–"]])"));
}

TEST_F(View, FailurePageDrawsWhatCollidesWhereTheSearchCameFarthest) {
  const Json& failure = seenFailure()["failure"];
  // The object and a frame with the hand for each tool, at their poses of the file.
  ASSERT_EQ(failure["farthest"].size(), 3u);
  expectPoint(failure["farthest"][0], {-0.1, 0, 0.4}, 1e-9);
  expectPoint(failure["farthest"][1], {-0.1, 0, 0.38}, 1e-9);
  expectPoint(failure["farthest"][2], {-0.1, 0, 0.46}, 1e-9);
  // The cup's picture, 1 cm along its link's z, and the table where it stands.
  ASSERT_EQ(failure["red_places"].size(), 2u);
  expectPoint(failure["red_places"][0], {-0.1, 0, 0.47}, 1e-6);
  expectPoint(failure["red_places"][1], {-0.4, 0, -0.01}, 1e-6);
  EXPECT_EQ(failure["red"],
            "Red: crane/cup and table, which collide. crane/cup is drawn where the search came "
            "farthest, table is drawn as it stands at the start.");
}

TEST_F(View, FailurePageShadesWhereTheArmsReachAndShowsTheFix) {
  const Json& failure = seenFailure()["failure"];
  EXPECT_EQ(failure["shaded"], (Json{4, 2, 1}));  // the left arm, the crane, and both
  EXPECT_THAT(failure["slice"].get<std::string>(), HasSubstr("at a height of 0.40 m"));
  EXPECT_EQ(failure["key"],
            Json::parse(R"(["box: solid as it starts, see-through where the search came farthest",
                            "duo/left: its hand where the search came farthest, and where it reaches",
                            "crane/arm: its hand where the search came farthest, and where it reaches",
                            "where both reach", "crane where it would work"])"));
  ASSERT_EQ(failure["fix"].size(), 1u);
  expectPoint(failure["fix"][0], {0.3, 0.7, 0}, 1e-9);
}

TEST_F(View, FailurePageTakesAFixOfTheWholeBase) {
  Json file = cell_.failure();
  file["explanation"]["nearest_fix"] = {
      {{"path", "robots.crane.base"}, {"value", "{xyz: [0.3, 0.75, 0], rpy_deg: [0, 0, -80]}"}}};
  const Json seen = browse(file);
  EXPECT_EQ(seen["error"], "");
  expectPoint(seen["failure"]["fix"][0], {0.3, 0.75, 0}, 1e-9);
}

TEST_F(View, ShowsAFailureWithoutFixOrFarthestAttempt) {
  Json file = cell_.failure();
  file["explanation"]["nearest_fix"] = nullptr;
  file["explanation"]["farthest"] = nullptr;
  file["explanation"]["fix_text"] = "";
  file["explanation"]["exhaustive"] = false;
  file["funnel"] = Json::object();
  const Json seen = browse(file);
  EXPECT_EQ(seen["error"], "");
  EXPECT_THAT(seen["failure"]["shaded"], IsEmpty());
  EXPECT_THAT(seen["failure"]["fix"], IsEmpty());
  EXPECT_THAT(seen["text"].get<std::string>(),
              AllOf(HasSubstr("No fix is known."), HasSubstr("did not try everything"),
                    Not(HasSubstr("farthest"))));
}

TEST_F(View, ManyCausesAreFoldedAway) {
  Json file = cell_.failure();
  Json& causes = file["explanation"]["causes"];
  for (int i = 0; i < 40; ++i) causes.push_back(causes[1]);
  EXPECT_EQ(browse(file)["failure"]["causes"], 8);
}

TEST_F(View, APageOfFailuresShowsTheOneThatItsAddressNames) {
  Json other = cell_.failure();
  other["explanation"]["reason"] = "no_path";
  const std::string page =
      failuresPage({{"run-3", cell_.failure().dump()}, {"run-7", other.dump()}}, cell_.root());
  // Once for both.
  const std::string mesh = "\"robots/duo/meshes/palm.obj\":{\"text\"";
  EXPECT_NE(page.find(mesh), std::string::npos);
  EXPECT_EQ(page.find(mesh), page.rfind(mesh));
  const std::string file = cell_.write("e.failures.html", page).string();
  for (const auto& [address, reason] :
       {std::pair("", "no handover pose"), {"#run-7", "no path"}, {"#run-3", "no handover pose"}}) {
    const Json seen = browsePage(file + address, {});
    EXPECT_EQ(seen["error"], "");
    EXPECT_THAT(seen["messages"], IsEmpty());
    EXPECT_EQ(seen["reason"], reason) << address;
    EXPECT_EQ(seen["failure"]["runs"], (Json{"run 3: no handover pose", "run 7: no path"}));
  }
  EXPECT_THROW(failuresPage({{"run-3", "{}"}}, cell_.root()), client::PlanFileError);
}

TEST_F(View, ShowsAPlanOfOneHolderThatHasTheObjectForGood) {
  Json file = cell_.plan();
  Json& plan = file["plan"];
  plan["holders"].erase(2);
  plan["holders"].erase(1);
  plan["handovers"] = Json::array();
  plan["stages"] = {stageOf(file, 0, "carry")};
  file["plan"]["stages"][0]["start"] = 0.0;
  file["plan"]["stages"][0]["index"] = 0;
  file["scene"]["start"]["held_by"] = "duo/left";
  file["quality"] = nullptr;
  file["complete"] = false;
  const Json seen = browse(file, {0.0, 1.6});
  EXPECT_EQ(seen["error"], "");
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_EQ(seen["title"], "sample: duo brings box");
  EXPECT_EQ(seen["cameras"], (Json{"cell", "start", "goal", "object"}));
  expectPoint(seen["at"][0]["object"], {-0.4, 0, 0.11}, 1e-6);
  expectPoint(seen["at"][1]["object"], {-0.1, 0, 0.4}, 1e-6);
  EXPECT_THAT(seen["text"].get<std::string>(), HasSubstr("ended by its deadline"));
}

TEST_F(View, ShowsWhatAPlanIsLike) {
  const Json seen = browse(cell_.plan(), {0.0, 3.0});
  EXPECT_EQ(seen["error"], "");
  EXPECT_THAT(seen["messages"], IsEmpty());
  const std::string text = seen["text"];
  for (const char* told :
       {"7.5 s at least", "6.3 s", "over 50 mm", "31 mm", "duo/l_palm – duo/r_palm", "12 mm",
        "box – ball", "90.0° from start to goal", "The box's lean"}) {
    EXPECT_THAT(text, HasSubstr(told));
  }
}

class Recording : public View {
 protected:
  Json read(const Json& plan) const {
    const Finished read = handover::test::run({NODE, READ_MCAP, write(plan, "plan.mcap")}, {}, 60s);
    EXPECT_EQ(read.status, 0) << read.err;
    return Json::parse(read.out);
  }

  static Json transformOf(const Json& message, const std::string& frame) {
    for (const Json& transform : message["transforms"]) {
      if (transform["child_frame_id"] == frame) return transform["transform"];
    }
    return {};
  }
};

TEST_F(Recording, IsReadByFoxglovesDecoder) {
  const Json seen = read(cell_.plan());
  EXPECT_EQ(seen["header"]["profile"], "ros2");
  EXPECT_TRUE(seen["done"]);
  EXPECT_TRUE(seen["ordered"]);
  const Json plan = cell_.plan();
  const double duration = plan["quality"]["duration_s"];
  const Json& joints = seen["topics"]["/joint_states/duo"];
  EXPECT_EQ(joints["type"], "sensor_msgs/msg/JointState");
  EXPECT_NEAR(joints["count"].get<double>(), 30 * duration, 2);
  EXPECT_NEAR(joints["last_time"].get<double>(), duration, 1e-6);
  EXPECT_EQ(joints["last"]["name"].size(), 10u);  // mimic joints too
  EXPECT_EQ(seen["topics"]["/stage"]["count"], plan["plan"]["stages"].size());
  EXPECT_EQ(seen["topics"]["/stage"]["first"]["data"], "duo/left reach");
  EXPECT_EQ(seen["topics"]["/stage"]["last"]["data"], "crane/arm home");
}

TEST_F(Recording, MovesTheObjectFromItsStartToItsGoal) {
  const Json seen = read(cell_.plan());
  const Json& tf = seen["topics"]["/tf"];
  const Json start = transformOf(tf["first"], "box"), goal = transformOf(tf["last"], "box");
  EXPECT_NEAR(start["translation"]["x"].get<double>(), -0.4, 1e-12);
  EXPECT_NEAR(goal["translation"]["x"].get<double>(), 0.4, 1e-9);
  EXPECT_NEAR(goal["translation"]["y"].get<double>(), 0.2, 1e-9);
  EXPECT_NEAR(goal["translation"]["z"].get<double>(), 0.06, 1e-9);
  // A quarter turn about z.
  EXPECT_NEAR(std::abs(goal["rotation"]["z"].get<double>()), std::sqrt(0.5), 1e-9);
  // What hangs on a robot goes with it.
  EXPECT_NEAR(transformOf(tf["last"], "sign")["translation"]["z"].get<double>(), 0.85, 1e-12);
  // A mimic finger follows the other one home.
  EXPECT_NEAR(transformOf(tf["last"], "duo/l_right_finger")["translation"]["y"].get<double>(),
              0.3 - 0.01, 1e-9);
}

TEST_F(Recording, ShowsEveryCollisionShape) {
  const Json seen = read(cell_.plan());
  const Json& markers = seen["topics"]["/scene"]["first"]["markers"];
  const auto of = [&](const std::string& body) {
    std::vector<Json> found;
    for (const Json& marker : markers) {
      if (marker["ns"] == body) found.push_back(marker);
    }
    return found;
  };
  EXPECT_EQ(of("shelf").size(), 2u);  // a compound's parts
  EXPECT_EQ(of("ball")[0]["scale"]["x"], 0.1);
  ASSERT_EQ(of("duo/l_palm").size(), 2u);
  const Json mesh = of("duo/l_palm")[1];
  EXPECT_EQ(mesh["points"].size(), 12u * 3);
  double widest = 0;
  for (const Json& p : mesh["points"]) widest = std::max(widest, p["y"].get<double>());
  EXPECT_NEAR(widest, 0.06, 1e-9);  // scaled
  std::vector<int> ids;
  for (const Json& marker : markers) ids.push_back(marker["id"]);
  EXPECT_EQ(std::set<int>(ids.begin(), ids.end()).size(), ids.size());
}

}  // namespace
}  // namespace handover::view::test
