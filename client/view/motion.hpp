// SPDX-License-Identifier: Apache-2.0
// Where the joints of a plan are at a time, and who holds the object.
#pragma once

#include "view/robot.hpp"

#include <nlohmann/json_fwd.hpp>

#include <limits>
#include <string>
#include <vector>

namespace handover::view {

struct Stage {
  std::size_t holder = 0;
  std::string action, robot;
  std::vector<std::string> joints;
  double start = 0;  ///< [s] from the plan's start
  std::vector<double> t;
  std::vector<std::vector<double>> q, qd, qdd;  ///< [sample][joint]

  double end() const { return start + t.back(); }

  /// On the quintic Hermite curves, `s` seconds after it began; before and after it stands still.
  std::vector<double> positionsAt(double s) const;
};

/// From the end of a grasp, or the plan's start, to the end of a release, or for good [s].
struct HoldTime {
  double from = 0, to = std::numeric_limits<double>::infinity();
};

class Motion {
 public:
  /// @param plan `plan` of a plan file. @throws Unreadable where samples do not match.
  explicit Motion(const nlohmann::json& plan);

  /// In order of time.
  const std::vector<Stage>& stages() const { return stages_; }

  /// One for each holder.
  const std::vector<HoldTime>& holds() const { return holds_; }

  double duration() const;

  /// When the last holder lets the object go; infinite if it never does.
  double putDown() const { return holds_.empty() ? HoldTime().to : holds_.back().to; }

  /// What a robot's joints are at, from `q` at the plan's start.
  Positions jointsAt(const std::string& robot, Positions q, double time) const;

 private:
  std::vector<Stage> stages_;
  std::vector<HoldTime> holds_;
};

}  // namespace handover::view
