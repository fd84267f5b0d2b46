// SPDX-License-Identifier: Apache-2.0
#include "core/planning/explanation.hpp"

#include <gmock/gmock.h>

namespace handover {
namespace {

using ::testing::HasSubstr;

PrunedByArm noneOf(Cause cause, std::uint32_t count) {
  PrunedGrasps pruned;
  pruned.tested = count;
  pruned.rejects.add(cause, count);
  return {{ArmName{"hubo", "left"}, pruned}};
}

TEST(ExplainSearch, SaysAtWhichHandoverOfAChainPosesEnded) {
  TransportProblem problem;
  problem.task.object = "box";
  SearchCounts counts;
  counts.lattice_points = 275;
  counts.poses_asked = 3973;
  counts.handover_rejects.add(Cause::kNoIk, 3965);
  EXPECT_EQ(explainSearch(problem, {}, {}, counts).explanation.text,
            "None of the 3973 handover poses tried lets both hands hold box.");
  counts.last_poses = 8;
  const Failed later = explainSearch(problem, {}, {}, counts);
  EXPECT_EQ(later.reason, FailureReason::kNoHandoverPose);
  EXPECT_EQ(later.explanation.text,
            "Of the 3973 handover poses tried 8 let both hands hold box at the chain's last "
            "handover, but no handover before it leads there.");
}

TEST(ExplainDeadline, KeepsWhatWasCountedOfMotions) {
  SearchCounts counts;
  counts.handover_rejects.add(Cause::kNoIk, 900);
  counts.motion_rejects.add(Cause::kNoPath, StageRef{1, StageAction::kCarry});
  const Failed late = explainDeadline({}, {}, counts);
  EXPECT_EQ(late.reason, FailureReason::kDeadline);
  EXPECT_EQ(late.explanation.filter, "motions");
  EXPECT_EQ(late.explanation.causes, counts.motion_rejects.counts());
  EXPECT_FALSE(late.explanation.exhaustive);
}

TEST(ExplainDeadline, KeepsWhatWasCountedOfHandoverPosesAndTheirCommonPair) {
  SearchCounts counts;
  counts.poses_asked = 40;
  counts.handover_rejects.add(Cause::kCollision, {"block", "hubo/palm"}, 39);
  counts.handover_rejects.add(Cause::kNoIk);
  const Failed late = explainDeadline({}, {}, counts);
  EXPECT_EQ(late.explanation.filter, "handover_poses");
  EXPECT_EQ(late.explanation.text,
            "block touches hubo/palm in 39 of 40 tries. The deadline passed after 40 handover "
            "poses were tried.");
  EXPECT_EQ(late.explanation.causes, counts.handover_rejects.counts());
}

TEST(ExplainDeadline, KeepsWhatWasCountedOfGrasps) {
  const Failed at_goal =
      explainDeadline(noneOf(Cause::kNoIk, 3), noneOf(Cause::kLimits, 5), SearchCounts{});
  EXPECT_EQ(at_goal.explanation.filter, "grasps_at_goal");
  EXPECT_EQ(at_goal.explanation.causes, (std::vector<CauseCount>{{Cause::kLimits, {}, {}, 5}}));
  const Failed at_start = explainDeadline(noneOf(Cause::kNoIk, 3), {}, SearchCounts{});
  EXPECT_EQ(at_start.explanation.filter, "grasps_at_start");
  EXPECT_EQ(at_start.explanation.causes, (std::vector<CauseCount>{{Cause::kNoIk, {}, {}, 3}}));
}

TEST(ExplainDeadline, SaysThatNothingWasTried) {
  const Failed late = explainDeadline({}, {}, SearchCounts{});
  EXPECT_THAT(late.explanation.text, HasSubstr("before anything was tried"));
  EXPECT_EQ(late.explanation.causes, (std::vector<CauseCount>{{Cause::kDeadline, {}, {}, 1}}));
}

}  // namespace
}  // namespace handover
