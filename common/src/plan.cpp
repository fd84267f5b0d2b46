// SPDX-License-Identifier: Apache-2.0
#include <handover/common/plan.hpp>

namespace handover {

const char* toString(StageKind kind) {
  switch (kind) {
    case StageKind::kUnspecified:
      return "unspecified";
    case StageKind::kGiverReach:
      return "giver_reach";
    case StageKind::kGiverApproach:
      return "giver_approach";
    case StageKind::kGiverGrasp:
      return "giver_grasp";
    case StageKind::kGiverLift:
      return "giver_lift";
    case StageKind::kGiverTransfer:
      return "giver_transfer";
    case StageKind::kReceiverReach:
      return "receiver_reach";
    case StageKind::kReceiverApproach:
      return "receiver_approach";
    case StageKind::kReceiverGrasp:
      return "receiver_grasp";
    case StageKind::kGiverRelease:
      return "giver_release";
    case StageKind::kGiverRetreat:
      return "giver_retreat";
    case StageKind::kReceiverTransfer:
      return "receiver_transfer";
    case StageKind::kReceiverPlace:
      return "receiver_place";
    case StageKind::kReceiverRelease:
      return "receiver_release";
    case StageKind::kReceiverRetreat:
      return "receiver_retreat";
  }
  return "unspecified";
}

const char* toString(FailureReason reason) {
  switch (reason) {
    case FailureReason::kUnspecified:
      return "unspecified";
    case FailureReason::kStartUnreachable:
      return "start_unreachable";
    case FailureReason::kGoalUnreachable:
      return "goal_unreachable";
    case FailureReason::kNoGraspAtStart:
      return "no_grasp_at_start";
    case FailureReason::kNoGraspAtGoal:
      return "no_grasp_at_goal";
    case FailureReason::kNoCommonWorkspace:
      return "no_common_workspace";
    case FailureReason::kNoHandoverPose:
      return "no_handover_pose";
    case FailureReason::kNoPath:
      return "no_path";
    case FailureReason::kStartInCollision:
      return "start_in_collision";
    case FailureReason::kGoalInCollision:
      return "goal_in_collision";
    case FailureReason::kDeadline:
      return "deadline";
    case FailureReason::kInternal:
      return "internal";
  }
  return "unspecified";
}

}  // namespace handover
