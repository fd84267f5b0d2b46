// SPDX-License-Identifier: Apache-2.0
// Timing of movements that need not keep to a polyline: a free part passes its waypoints at speed,
// and the curve leaves the straight lines between them (as far as that is quicker).
#pragma once

#include "core/motion/timing.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace handover {

/// Part of a movement. Lines are kept to; of a free part the waypoints are passed, no more.
struct MovementPart {
  std::vector<Eigen::VectorXd>
      waypoints;  ///< two at least; the first is the last of the part before
  bool line = false;
  bool operator==(const MovementPart&) const = default;
};

/// Joints that go from rest to rest during one part, whatever the others do, and stand still else.
struct JointsAside {
  std::size_t part = 0;
  Eigen::VectorXd from, to;
};

/// Parts that follow one another as one motion from rest to rest, with the joints aside below the
/// others. The free part is crossed in the least time that its joints need from state to state
/// (LeastTimeMotion); at its ends it takes over the velocity of the line that it comes from or
/// leads to, and its inner waypoints are passed at velocities along the way.
class ThroughMovement {
 public:
  /// @param boldness  in (0, 1]: how near to the best of these velocities; the less, the nearer the
  ///                  curve stays to the polyline.
  /// @param blend  of the lines' corners [rad].
  /// @pre one free part, with at most one line before it and one after it; sizes agree.
  ThroughMovement(const std::vector<MovementPart>& parts, const std::optional<JointsAside>& aside,
                  const TimingLimits& limits, double blend, double boldness);
  ~ThroughMovement();
  ThroughMovement(ThroughMovement&&) noexcept;
  ThroughMovement& operator=(ThroughMovement&&) noexcept;

  /// False: no such motion was found, or it takes minutes.
  bool found() const;

  /// [s] before its jerk is bounded and its speed scaled. @pre found().
  double duration() const;

  /// The timed curve. A junction's `first` is the last sample before it, `last` the first after
  /// which the curve is the next part's alone. @pre found().
  JoinedTiming timing(const TimingSettings& settings) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handover
