// SPDX-License-Identifier: Apache-2.0
// Timed paths, as the collision checks want to know motions.
#pragma once

#include "core/collision/joint_motion.hpp"
#include "core/motion/trajectory.hpp"

namespace handover {

/// A timed path from one time to another [s], evenly; before its start and after its end it stands
/// still. The path outlives this. Safe from any thread.
class TimedMotion : public JointMotion {
 public:
  explicit TimedMotion(const TimedPath& path) : TimedMotion(path, 0, path.duration()) {}

  TimedMotion(const TimedPath& path, double begin, double end)
      : path_(path), begin_(begin), end_(end) {}

  Eigen::Index joints() const override { return path_.q.front().size(); }

  /// `q_middle` is on the curve, `along` half of the way from the stretch's begin to its end; what
  /// that line leaves of the curve is enclosed by the control points of its quintics.
  void fill(double from, double to, MotionIntervalRef out) const override;

 private:
  const TimedPath& path_;
  const double begin_, end_;
};

}  // namespace handover
