// SPDX-License-Identifier: Apache-2.0
// A plan as an MCAP recording, as ROS 2 tools read it.
#pragma once

#include "verify/motion.hpp"

#include <string>

namespace handover::view {

/// The bytes of an unchunked MCAP file, profile ros2, time from 0 [ns], 30 frames a second:
/// /joint_states/ROBOT (sensor_msgs/JointState), /tf (tf2_msgs/TFMessage: `robot/link` and objects
/// in `world`), /scene (visualization_msgs/MarkerArray: every shape as triangles in those frames),
/// /stage (std_msgs/String: a stage's kind as it begins).
std::string planMcap(const verify::Motion& motion);

}  // namespace handover::view
