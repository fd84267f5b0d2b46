// SPDX-License-Identifier: Apache-2.0
// How hard the search tries: counts, never seconds, so that the same request gives the same plan.
// Values without a source were chosen by `./run bench` and experiments of 100 draws per cell, as
// said beside them.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace handover {

/// Clearances of free motions to all that is not close by nature [m], the first that gives one.
/// From none on, that of every motion is enough.
using Skins = std::vector<double>;

/// Paths of arms that are not straight lines of the tool.
struct FreeMotionSettings {
  Skins skins;
  std::uint32_t rrt_iterations = 1000;  ///< 600 left 3 of 400 draws without a path, 2000 none more
  /// Once so many trees of a request have failed, the next get fewer iterations: nine of ten
  /// requests that are solved at all have seen fewer fail. To go on falling lost 2 of 100 draws.
  std::uint32_t patient_trees = 4, rrt_iterations_then = 400;
  std::uint32_t shortcut_attempts = 16;
  std::uint32_t direct_goals = 4;  ///< goals to which a roadmap path is tried before RRT
  /// Segments looked at for a roadmap path, first and, where that was in vain, once more.
  std::uint32_t few_checks = 15, most_checks = 150;
  std::size_t simple_path = 3;  ///< waypoints of roadmap paths, mostly; longer ones came from RRT
  /// Cost bound on a roadmap path, relative to the direct one; beyond it RRT is tried instead.
  double most_detour = 2.2;
  double corner_time = 0.5;  ///< what a corner costs, about [s]
  double most_corners = 4;
  double rounding = 0.05;  ///< corners can be cut by so much when timed [rad]
  /// Via configurations: the tool back from an end [m], aside from there, or up.
  std::array<double, 3> back{0.05, 0.12, 0.25};
  double aside = 0.12;
  std::array<double, 2> up{0.12, 0.25};
  double farthest_via = 1.5;     ///< of one joint, from the end that a via is back or up from [rad]
  std::size_t bowed_joints = 4;  ///< those that carry the hand
  std::array<double, 4> bow{0.7, -0.7, 1.4, -1.4};  ///< [rad]
};

/// Straight lines of the tool: the longest that works, by falling length [m].
struct LinearMotionSettings {
  std::array<double, 3> retreat{0.10, 0.07, 0.04};
  std::array<double, 3> lift{0.08, 0.05, 0.03};  ///< the descent of a place, too
};

/// How hard a free configuration of a grasp is looked for.
struct PruneEffort {
  int swivels = 8;                  ///< IkQuery::swivel_samples
  std::size_t configurations = 12;  ///< tested before the grasp is given up
  bool proof = false;  ///< hands are tested, too, where joint limits alone stand against the arm
  bool operator==(const PruneEffort&) const = default;
};

/// Modes best and all: how long they go on after the first plan, in counts.
struct ImprovementSettings {
  std::uint32_t looks = 4'000;  ///< candidates asked whether both arms reach them, per round
  std::uint32_t poses = 24;     ///< of these, whose grasps are pruned
  std::size_t plans = 9;        ///< tuples whose motions are sought
  std::size_t plans_ranked = 16, ranked = 10;  ///< mode all: so many of them, and sent
  std::size_t per_pose = 2;                    ///< of one pose
  int rounds = 2;                      ///< the first anywhere, the others near the best so far
  double near = 0.15;                  ///< [m]
  std::size_t places = 3;              ///< configurations of a grasp at the goal
  std::uint32_t rrt_iterations = 150;  ///< of trees, which take the most time
  Skins skins{0.022, 0.012, 0.006};    ///< a little more than what is asked of a plan
};

/// What a second is worth (design §7, Objective): `balanced` adds these to a plan's duration.
struct CostWeights {
  double clearance = 3;  ///< [s] of each kind, at none; from `wide` on 0
  double wide = 0.020;   ///< [m]
  double grip = 4;       ///< [s] of the weaker one at none, from `firm` of its set's best on 0
  double firm = 0.5;
  double turn = 0.5;  ///< [s] per quarter turn of the object beyond the least
  double limit = 2;   ///< [s] of a joint at its limit, from `margin` of its range on 0
  double margin = 0.05;
  double dexterous = 0.8;  ///< of the best placing's manipulability; below that: `clumsy`
  double clumsy = 1000;    ///< [s]
};

struct SearchSettings {
  FreeMotionSettings free_motion;
  LinearMotionSettings linear_motion;
  PruneEffort pruning;
  PruneEffort thorough_pruning{64, 512,
                               true};  ///< before it is said that a robot has no grasp at all
  std::size_t configurations = 4;      ///< of a grasp, tried as ends of motions

  double neighbourhood = 0.20;  ///< [paper] §IV-B: lattice points near the midpoint [m]
  /// Of the lattice points that `wide` adds: 0.20 left 3 of 100 draws of butler_left without any
  /// [m].
  double wide_neighbourhood = 0.45;
  /// Between two arms of one robot, whose shoulders' midpoint is in its body; `wide` only [m].
  double same_robot_neighbourhood = 0.80;
  std::size_t wide_points = 24;        ///< lattice points that `wide` adds first, by score
  int wide_turns = 8;                  ///< rotations about z_shoulder that `wide` adds
  double most_tilt = 60 * M_PI / 180;  ///< of the approach axis, in what `wide` draws last [rad]
  /// Handover poses that `wide` asks for at most. Most fall to the cheap test for a straight path
  /// there; mode all, which counts as the paper does, has no such test.
  std::uint32_t wide_poses = 8'000;
  std::uint32_t wide_poses_counted = 1'500;
  std::uint32_t scattered_poses = 150'000;  ///< most fall to a look at each arm's reach
  /// The same where two arms of the chain have no lattice point in common: of 3,100 requests to our
  /// cells one such was solved.
  std::uint32_t scattered_poses_apart = 80'000;
  /// Poses whose collisions are looked at, at most: of 2,100 draws of our cells (seeds 1 to 3) the
  /// solved ones took up to 225 of the turned ones, and 54 of the scattered.
  std::uint32_t turned_looks = 300, scattered_looks = 300;
  std::uint32_t most_looks = 900;  ///< of a chain, whatever the tier and the handover
  /// Poses of a tool for which any configuration was looked for, of a request; more than 70,000
  /// were needed.
  std::uint32_t most_ik_looks = 100'000;
  /// So few grasps of the first holder are tried by themselves before these poses; all of them
  /// together with so many times the effort of one.
  std::size_t few_takes = 16, takes_patience = 64;
  /// Failed IK solves of arms without a closed form, for each tier of `wide`: 0.2 s. Of 240
  /// requests drawn about two such arms 10,000 solved one more, and took 2 s where none was solved.
  std::uint32_t most_failed_ik = 2'000;
  std::size_t tuples_per_pose = 3;  ///< tuples of one pose whose motions are tried
  /// Lattice points with so many failed motions so near [m] wait until all others are tried:
  /// neighbours fail alike.
  std::ptrdiff_t crowd_failures = 4;
  double crowd_radius = 0.12;
  std::uint32_t turned_motions = 45;   ///< of the next, before poses are drawn at random
  std::uint32_t motion_attempts = 70;  ///< tuples of a request whose motions are tried; up to 42
                                       ///< were needed
  std::uint32_t grasp_attempts = 500;  ///< tuples whose hands did not go together; 387 were needed
  std::uint32_t grasp_attempts_inner = 200;  ///< in chains of more than one handover; 185 were
  std::uint32_t failed_trees = 60;           ///< of a request, most of the time of those that fail
  /// Ways of one of a chain's givers, to where it gives the object or home, that were sought in
  /// vain: of 3,752 requests that were solved, drawn about our cells, one needed 15.
  std::uint32_t failed_ways = 20;
  // Of the handovers before a chain's last one: per grasp of the receiver where it gives the object
  // on, poses and grasps of the giver that are followed up; in all; and how often a grasp may fail.
  std::uint32_t inner_poses = 200;
  std::size_t inner_gives = 16;  ///< grasps of the giver looked at, whether both hands fit
  std::size_t inner_tuples = 3;
  std::uint32_t most_inner_poses = 3'000;  ///< of a chain; up to 2,445 were needed
  std::uint32_t inner_failures = 2;
  std::size_t most_auto_holders = 4;  ///< design §1
  /// What is found for one tuple depends on it alone, whatever was tried before.
  bool independent = false;
  ImprovementSettings improvement;
  CostWeights cost;
};

}  // namespace handover
