// SPDX-License-Identifier: Apache-2.0
// Iterative steps on a chain's own forward kinematics: the polish of closed-form answers, the
// tracking of straight lines, and the search for chains without a closed form.
#pragma once

#include "core/kinematics/chain.hpp"

namespace handover::kinematics {

/// How near an answer's pose must be [m and rad].
inline constexpr double kPoseTolerance = 1e-9;

/// A few Newton steps (the least joint motion each) from a configuration that is nearly right,
/// limits ignored. False if the tolerance is not reached.
bool polish(const Chain& chain, const Pose& X_AT, ArmVector& q);

/// The configuration of X_AT nearest to q_near, by Newton steps whose null-space part goes back to
/// q_near; a joint that meets its limit stays there. False if it does not converge.
bool track(const Chain& chain, const Pose& X_AT, const ArmVector& q_near, ArmVector& q);

/// Levenberg-Marquardt from q. Sliding joints and those that turn through less than a full turn
/// keep their limits; the others end at any of an angle's copies, which may all lie in what the
/// limits leave out. False if it gets stuck.
bool descend(const Chain& chain, const Pose& X_AT, ArmVector& q);

}  // namespace handover::kinematics
