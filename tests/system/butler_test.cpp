// SPDX-License-Identifier: Apache-2.0
// The butler over the wire, by the real programs: planned, verified, the same every time.
#include "plan_text.hpp"
#include "served_cells.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

namespace handover::test {
namespace {

using testing::HasSubstr;

/// Lowest and highest corner of a group of a Wavefront text.
std::pair<double, double> heights(const std::string& obj, const std::string& group) {
  std::pair<double, double> range{1e9, -1e9};
  std::istringstream lines(obj);
  std::string kind, name;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    double x = 0, y = 0, z = 0;
    words >> kind;
    if (kind == "o") words >> name;
    if (kind != "v" || name != group) continue;
    words >> x >> y >> z;
    range = {std::min(range.first, z), std::max(range.second, z)};
  }
  return range;
}

class Butler : public ServedCells {
 protected:
  void serve(int threads) { ServedCells::serve("--cell butler", HANDOVER_SOURCE_DIR, threads); }

  Finished plan(const std::string& output, const std::string& more = "") const {
    return run(ctl("plan --cell butler --output " + file(output) + " " + more), {}, 240s);
  }

  /// The text of the file's members `scene` and `plan`, as it stands in the file.
  std::string planText(const std::string& name) const { return planMember(textOf(file(name))); }
};

TEST_F(Butler, PlanIsCompleteAndVerified) {
  serve(1);
  std::vector<std::string> command = ctl("plan --cell butler --output " + file("p.json"));
  command.insert(command.end(), {"--dump-state", "place.1", file("placed.obj")});
  const Finished planned = run(command, {}, 240s);
  ASSERT_EQ(planned.status, 0) << planned.out << planned.err;
  const auto document = nlohmann::json::parse(textOf(file("p.json")));
  EXPECT_EQ(document["format"], "handover-plan/2");
  EXPECT_EQ(document["complete"], true);
  EXPECT_EQ(document["plan"]["stages"].size(), 16u);
  ASSERT_EQ(document["plan"]["holders"].size(), 2u);
  EXPECT_EQ(document["plan"]["handovers"].size(), 1u);
  EXPECT_EQ(document["plan"]["holders"][0]["robot"], "crichton");
  EXPECT_EQ(document["plan"]["holders"][1]["robot"], "hubo");
  EXPECT_EQ(document["plan"]["holders"][1]["arm"], "left");
  expectValid("p.json");
  // The receiver reaches while the giver carries, and we are told what that is worth.
  double end = 0, sum = 0, reach = 0, carried = 0;
  for (const auto& stage : document["plan"]["stages"]) {
    const double start = stage["start"], duration = stage["t"].back();
    if (stage["holder"] == 1 && stage["action"] == "reach") reach = start;
    if (stage["holder"] == 0 && stage["action"] == "carry") carried = start + duration;
    end = std::max(end, start + duration);
    sum += duration;
  }
  EXPECT_LT(reach, carried);
  EXPECT_NEAR(document["timing"]["motion_s"], end, 1e-9);
  EXPECT_NEAR(document["timing"]["overlap_saves_s"], sum - end, 1e-9);
  EXPECT_THAT(planned.out + planned.err, HasSubstr("less than one stage after the other"));
  // Placed: the cup stands on the tray, neither in it nor above it.
  const std::string placed = textOf(file("placed.obj"));
  EXPECT_NEAR(heights(placed, "cup").first, heights(placed, "tray").second, 2e-3);
  EXPECT_NEAR(heights(placed, "cup").second - heights(placed, "cup").first, 0.151, 1e-3);
  stop();
}

TEST_F(Butler, CupGoesBackFromTheTrayToTheCart) {
  serve(1);
  const Finished planned = plan("r.json", "--task return");
  ASSERT_EQ(planned.status, 0) << planned.out << planned.err;
  const auto document = nlohmann::json::parse(textOf(file("r.json")));
  EXPECT_EQ(document["plan"]["holders"][0]["robot"], "hubo");
  EXPECT_EQ(document["plan"]["holders"][0]["arm"], "left");
  EXPECT_EQ(document["scene"]["start"]["rest"], nlohmann::json({"tray"}));
  EXPECT_EQ(document["scene"]["goal"]["rest"], nlohmann::json({"cart_left"}));
  bool found = false;
  for (const auto& object : document["scene"]["objects"]) {
    if (object["name"] != "cup") continue;
    found = true;
    // Start and goal speak for it.
    EXPECT_EQ(object["resting"], nlohmann::json::array());
  }
  EXPECT_TRUE(found);
  expectValid("r.json");
  stop();
}

TEST_F(Butler, PlanIsTheSameForAnyThreadsAloneOrAmongOthers) {
  serve(1);
  ASSERT_EQ(plan("alone.json").status, 0);
  stop();
  const std::string alone = planText("alone.json");
  ASSERT_GT(alone.size(), 1000u);

  serve(2);
  ASSERT_EQ(plan("two.json").status, 0);
  EXPECT_EQ(planText("two.json"), alone);
  // Among three others with other scenes and seeds, before and after it in the queue.
  const std::vector<std::pair<std::string, std::string>> others{
      {"seed.json", "--seed 7"},
      {"moved.json", "--set robots.hubo.base.xyz=[1.18,-0.1,0.98]"},
      {"paper.json", "--search paper --seed 3"}};
  std::map<std::string, std::string> before;
  for (const bool first : {true, false}) {
    std::vector<std::unique_ptr<Process>> running;
    const auto start = [&](const std::string& name, const std::string& more) {
      running.push_back(
          std::make_unique<Process>(ctl("plan --cell butler --output " + file(name) + " " + more)));
    };
    if (first) start("among.json", "");
    for (const auto& [name, more] : others) start(name, more);
    if (!first) start("among.json", "");
    for (auto& process : running) ASSERT_EQ(process->wait(240s), 0) << process->err();
    EXPECT_EQ(planText("among.json"), alone) << (first ? "first" : "last");
    for (const auto& [name, more] : others) {
      const std::string text = planText(name);
      EXPECT_NE(text, alone) << more;
      const auto [known, is_new] = before.emplace(name, text);
      EXPECT_EQ(text, known->second) << more;
      if (!is_new) continue;
      expectValid(name);
    }
  }
  expectValid("among.json");
  stop();
}

TEST_F(Butler, PlanIsTheSameAfterOverridesAndBack) {
  serve(1);
  ASSERT_EQ(plan("before.json").status, 0);
  ASSERT_EQ(plan("moved.json",
                 "--set robots.hubo.base.xyz=[1.18,-0.1,0.98] "
                 "--set objects.cup.pose.xyz=[-0.25,-0.75,0.903]")
                .status,
            0);
  ASSERT_EQ(plan("none.json", "--set robots.hubo.base.xyz=[6,-0.3,0.98]").status, 10);
  ASSERT_EQ(plan("none.json", "--set robots.hubo.base.xyz=[.nan,0,0]").status, 12);
  ASSERT_EQ(plan("after.json").status, 0);
  EXPECT_EQ(planText("before.json"), planText("after.json"));
  EXPECT_NE(planText("before.json"), planText("moved.json"));
  for (const char* name : {"moved.json", "after.json"}) {
    expectValid(name);
  }
  stop();
}

TEST_F(Butler, ReceiverOutOfReachFailsWithReasonAndCounts) {
  serve(1);
  const Finished far =
      run(ctl("plan --cell butler --json --set robots.hubo.base.xyz=[6,-0.3,0.98]"), {}, 240s);
  EXPECT_EQ(far.status, 10) << far.out << far.err;
  EXPECT_THAT(far.out, HasSubstr("no_common_workspace"));
  EXPECT_THAT(far.out, HasSubstr("\"kept\""));
  stop();
}

TEST_F(Butler, SigtermWhilePlanningGivesTheOutcome) {
  serve(1);
  // A search over everything takes long enough to be interrupted in the middle.
  Process asking(ctl("plan --cell butler --mode all --set robots.hubo.base.xyz=[1.18,-1.1,0.98]"));
  ASSERT_TRUE(asking.waitForOutput("grasps", 120s)) << asking.err();
  daemon_->signal(SIGTERM);
  const auto status = asking.wait(60s);
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(*status, 11) << asking.out() << asking.err();
  EXPECT_EQ(daemon_->wait(), 0);
}

}  // namespace
}  // namespace handover::test
