// SPDX-License-Identifier: Apache-2.0
// The program on made-up records: one run that is easy, and one that nobody can plan.
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <vector>

namespace handover::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class DenseSearch : public testing::Test {
 protected:
  Finished search(const json& experiment) const {
    const std::string file = folder_ / "experiment.json";
    std::ofstream(file) << experiment;
    return run({HANDOVER_BINARY_DIR "/bin/dense_search", file, "--root", HANDOVER_SOURCE_DIR},
               {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"}, 100s);
  }

  static json experimentOf(const std::vector<json>& records, const std::string& cell = "butler") {
    return {{"format", "handover-experiment/2"}, {"cell", cell}, {"records", records}};
  }

  static json failedRun(const json& drawn) {
    return {{"index", 0},
            {"seed", 1},
            {"drawn", drawn},
            {"outcome", "failed"},
            {"reason", "no_handover_pose"}};
  }

  TemporaryFolder folder_;
};

TEST_F(DenseSearch, FindsAPlanWhereThereAreMany) {
  const Finished found =
      search(experimentOf({failedRun({{"robots.hubo.base.xyz", {1.18, -0.2, 0.98}}}),
                           {{"index", 1}, {"outcome", "done"}}}));
  ASSERT_EQ(found.status, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("solved by dense search: crichton/right -> hubo/left"));
  EXPECT_THAT(found.out, HasSubstr("solves 1 of 1 failures; the planner solved 1 of 2"));
}

TEST_F(DenseSearch, FindsNoneForAReceiverThreeMetresAway) {
  const Finished none =
      search(experimentOf({failedRun({{"robots.hubo.base.xyz", {3.0, -0.3, 0.98}}})}));
  ASSERT_EQ(none.status, 0) << none.err;
  EXPECT_THAT(none.out, HasSubstr("no plan in 0 poses, infeasible on this grid"));
  EXPECT_THAT(none.out, HasSubstr("solves 0 of 1 failures"));
}

TEST_F(DenseSearch, SaysThatTheGoalIsInTheAir) {
  const Finished none = search(experimentOf({failedRun({{"tasks.serve.goal.xyz", {0, 0, 0.2}}})}));
  ASSERT_EQ(none.status, 0) << none.err;
  EXPECT_THAT(none.out, HasSubstr("no plan in 0 poses, infeasible on this grid"));
  EXPECT_THAT(none.out, HasSubstr("At its goal cup rests on nothing"));
}

TEST_F(DenseSearch, RefusesChainsOfOtherThanTwo) {
  for (const auto& [cell, holders] : {std::pair("pick_place", "has 1"), {"relay", "has 3"}}) {
    const Finished refused = search(experimentOf({failedRun(json::object())}, cell));
    EXPECT_EQ(refused.status, 1) << cell;
    EXPECT_THAT(refused.err,
                HasSubstr(std::string("needs a chain of two holders; the task ") + holders));
  }
}

TEST_F(DenseSearch, RefusesAnotherSortOfFile) {
  const Finished refused = search({{"format", "handover-plan/1"}});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("is no handover-experiment/2 file"));
}

}  // namespace
}  // namespace handover::test
