// SPDX-License-Identifier: Apache-2.0
// handoverctl view, and its page in a real browser.
#include "client/verify/gantry_plan.hpp"
#include "support/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace handover::verify::test {
namespace {

using handover::test::Finished;
using handover::test::textOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using namespace std::chrono_literals;

class View : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (cell_.root() / name).string(); }

  Finished view(const Json& plan, const std::string& output = "plan.html") const {
    cell_.write("plan.json", plan.dump());
    return handover::test::run({HANDOVERCTL, "view", path("plan.json"), "-o", path(output),
                                "--root", cell_.root().string()});
  }

  const GantryCell cell_;
};

TEST_F(View, WritesOnePageThatReachesForNothingOutside) {
  const Finished made = view(cell_.plan());
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string page = textOf(path("plan.html"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'; script-src 'sha256-"));
  EXPECT_THAT(page, Not(HasSubstr("unsafe-inline")));
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, Not(HasSubstr("<link ")));
  EXPECT_THAT(page, HasSubstr("\"robots/gantry/gantry.urdf\""));
}

TEST_F(View, KeepsMarkupInNamesOutOfThePage) {
  Json plan = cell_.plan();
  plan["plan"]["task"] = "</script><script>alert(1)</script>";
  const Finished made = view(plan);
  ASSERT_EQ(made.status, 0) << made.err;
  const std::string page = textOf(path("plan.html"));
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cscript>alert(1)"));
}

TEST_F(View, SaysWhatItCannotReadOrWrite) {
  EXPECT_THAT(view({{"format", "other"}}).err, HasSubstr("format"));
  EXPECT_EQ(view({{"format", "other"}}).status, 2);

  Json plan = cell_.plan();
  robot(plan, "g")["urdf"] = "robots/none.urdf";
  EXPECT_THAT(view(plan).err, HasSubstr("robots/none.urdf: no such file"));
  EXPECT_EQ(view(plan).status, 2);

  const Finished nowhere = view(cell_.plan(), "none/plan.html");
  EXPECT_EQ(nowhere.status, 3);
  EXPECT_THAT(nowhere.err, HasSubstr("none/plan.html"));
}

TEST_F(View, PageRunsInABrowser) {
  ASSERT_EQ(view(cell_.plan()).status, 0);
  const Finished browsed = handover::test::run(
      {NODE, BROWSE, path("plan.html"), "g", "tool", "0:cell:" + path("start.png")}, {}, 120s);
  ASSERT_EQ(browsed.status, 0) << browsed.err;
  const Json seen = Json::parse(browsed.out);
  EXPECT_TRUE(seen["shown"]) << seen;
  EXPECT_THAT(seen["messages"], IsEmpty());
  EXPECT_THAT(seen["requests"], IsEmpty());
  EXPECT_EQ(seen["bars"], 14);
  const double duration = seen["duration"];
  EXPECT_NEAR(seen["time_after_click"], 0.5 * duration, 0.02 * duration);
  EXPECT_GT(seen["time_after_play"], seen["time_after_click"]);
  EXPECT_NE(seen["link_after_click"], seen["link_at_start"]);
  EXPECT_GT(seen["colours"], 100) << "the picture is blank";
  EXPECT_GT(std::filesystem::file_size(path("start.png")), 10'000u);
}

TEST_F(View, RecordingIsReadByFoxglovesDecoder) {
  const Finished made = view(cell_.plan(), "plan.mcap");
  ASSERT_EQ(made.status, 0) << made.err;
  const Finished read = handover::test::run({NODE, READ_MCAP, path("plan.mcap")}, {}, 60s);
  ASSERT_EQ(read.status, 0) << read.err;
  const Json seen = Json::parse(read.out);
  EXPECT_EQ(seen["header"]["profile"], "ros2");
  EXPECT_TRUE(seen["done"]);
  EXPECT_TRUE(seen["ordered"]);

  const Json plan = cell_.plan()["plan"];
  const Json& last_stage = plan["stages"].back();
  const double duration = last_stage["start"].get<double>() + last_stage["t"].back().get<double>();
  const Json& joints = seen["topics"]["/joint_states/r"];
  EXPECT_EQ(joints["type"], "sensor_msgs/msg/JointState");
  EXPECT_NEAR(joints["count"], 30 * duration, 2);
  EXPECT_NEAR(joints["last_time"], duration, 1e-6);
  // The receiver's last stage ends where its joints say.
  for (std::size_t j = 0; j < last_stage["joints"].size(); ++j) {
    const auto& names = joints["last"]["name"];
    const auto at = std::find(names.begin(), names.end(), last_stage["joints"][j]) - names.begin();
    EXPECT_NEAR(joints["last"]["position"][static_cast<std::size_t>(at)],
                last_stage["q"].back()[j].get<double>(), 1e-9);
  }
  // The object goes from its start to its goal.
  const auto objectIn = [&](const Json& message) {
    for (const Json& transform : message["transforms"]) {
      if (transform["child_frame_id"] == plan["object"])
        return transform["transform"]["translation"];
    }
    return Json();
  };
  const Json& tf = seen["topics"]["/tf"];
  EXPECT_NEAR(objectIn(tf["first"])["x"], plan["X_WO_start"]["xyz"][0].get<double>(), 1e-9);
  EXPECT_NEAR(objectIn(tf["last"])["y"], plan["X_WO_goal"]["xyz"][1].get<double>(), 1e-3);
  EXPECT_EQ(seen["topics"]["/stage"]["count"], 14);
  EXPECT_EQ(seen["topics"]["/stage"]["last"]["data"], "receiver_retreat");
  const Json& markers = seen["topics"]["/scene"]["first"]["markers"];
  EXPECT_GT(markers.size(), plan["objects"].size());
  for (const Json& marker : markers) EXPECT_EQ(marker["points"].size() % 3, 0u);
}

}  // namespace
}  // namespace handover::verify::test
