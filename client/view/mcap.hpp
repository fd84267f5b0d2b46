// SPDX-License-Identifier: Apache-2.0
// A plan as an MCAP recording, as ROS 2 tools read it.
#pragma once

#include <filesystem>
#include <string>

namespace handover::view {

/// The bytes of an unchunked MCAP file, profile ros2, time from 0 [ns], 30 frames a second:
/// /joint_states/ROBOT (sensor_msgs/JointState), /tf (tf2_msgs/TFMessage: `robot/link` and objects
/// in `world`), /scene (visualization_msgs/MarkerArray: every collision shape in those frames),
/// /stage (std_msgs/String: `robot/arm action` as a stage begins).
/// @param root folder that the plan's paths are relative to.
/// @throws client::PlanFileError when the text holds no plan, or a file that it names cannot be
/// read.
std::string planMcap(const std::string& plan_text, const std::filesystem::path& root);

}  // namespace handover::view
