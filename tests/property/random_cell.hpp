// SPDX-License-Identifier: Apache-2.0
// Random cells of two small robots, a box that changes hands, a few obstacles: some have a
// handover, some have none.
#pragma once

#include "core/planning/plan_transport.hpp"
#include "small_robots.hpp"

#include <rapidcheck.h>

#include <iosfwd>

namespace handover::test {

/// What is drawn; the seed decides the rest. Smaller is simpler.
struct CellDraw {
  RobotKind giver = RobotKind::kPlanar, receiver = RobotKind::kPlanar;
  int giver_size = 0, receiver_size = 0;  ///< which of its kind
  int grasps = 4;                         ///< of each hand
  int obstacles = 0;
  bool far = false;  ///< start or goal put somewhere, not where a tool can be
  std::uint64_t seed = 0;
  bool hold = false;   ///< the receiver keeps the box at its goal
  bool loose = false;  ///< boards may be lower than the box rests, posts inside what stands there
};

std::ostream& operator<<(std::ostream& out, const CellDraw& draw);

rc::Gen<CellDraw> anyCell();

struct RandomCell {
  const SmallRobot* giver = nullptr;
  const SmallRobot* receiver = nullptr;
  TransportProblem problem;  ///< robots: giver, receiver; one arm each
};

/// The same cell for the same draw.
RandomCell makeCell(const SmallRobots& robots, const CellDraw& draw);

}  // namespace handover::test
