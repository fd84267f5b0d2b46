// SPDX-License-Identifier: Apache-2.0
// Pairs of bodies along a motion, by conservative advancement: a pair that has room d cannot use it
// up before its bodies have moved by d against each other, and how far they can move is bounded
// from the joint speeds. Pairs with much room are hardly ever looked at, near ones as often as they
// need.
#pragma once

#include "verify/bodies_in_motion.hpp"
#include "verify/motion.hpp"
#include "verify/report.hpp"

#include <cstddef>
#include <vector>

namespace handover::verify {

class PairSweep {
 public:
  struct Pair {
    int a = -1, b = -1;      ///< bodies, a < b
    int stage = -1;          ///< one that moves them, the last of them
    std::size_t shared = 0;  ///< joints above both, which do not move them against each other
    double slack = 0;        ///< [m] that it may still move before it must be looked at
    int tag = 0;             ///< the client's own
    double depth = -1;       ///< the client's own: allowed depth [m], negative: none
  };

  /// Who wants to know.
  class Client {
   public:
    virtual ~Client() = default;
    /// A stretch of time begins in which the same stages run and the same hands hold.
    virtual void interval(double middle, const std::vector<int>& running) = 0;
    /// Whether a pair that some running stage moves is to be looked at. @param rigid nothing moves
    /// the two against each other.
    virtual bool select(Pair& pair, bool rigid) = 0;
    /// How far the two may move against each other before they must be looked at again; motion of
    /// less than half a millimetre is not divided further. Negative: not any more in this stretch.
    virtual double look(const Pair& pair, const Pose& X_WA, const Pose& X_WB, double T) = 0;
  };

  /// @param cuts times, besides starts and ends of stages, at which what matters changes.
  PairSweep(const Motion& motion, const std::vector<double>& cuts, Effort& effort);

  /// Every pair as it stands at the start; select() is not asked.
  void atStart(Client& client);
  void along(Client& client);

  /// The link that the body moves with in the current stretch.
  const Mount& mount(int body) const { return mounts_[static_cast<std::size_t>(body)]; }

  /// Whether a running stage moves the body.
  bool moved(int body) const { return !joints_[static_cast<std::size_t>(body)].empty(); }

  /// Whether the stage moves the body.
  bool movedBy(int stage, int body) const;

 private:
  void interval(double from, double to, Client& client);
  void mountBodies(double T);
  int runningStageOf(int robot, int joint) const;
  void findPairs(Client& client);
  std::size_t sharedJoints(int a, int b) const;
  void place(double T);
  void boundTravel(double duration);
  void segment(double from, double to, Client& client);
  void step(double from, double to, Client& client);
  bool advance(Pair& pair, double from, double to, double travel, bool& disturbed, Client& client);
  double look(const Pair& pair, double T, Client& client);
  void drop(std::size_t p);

  const Motion& motion_;
  const Scene& scene_;
  std::vector<double> cuts_;
  Effort& effort_;
  double states_ = 0;
  std::vector<Mount> mounts_;  // per body
  // Of the current stretch:
  std::vector<int> running_;
  std::vector<std::vector<int>> joints_;  // per body: moving joints above it, root first
  std::vector<Pair> pairs_;
  // Of the current time:
  std::vector<std::vector<Pose>> link_poses_;  // per robot
  std::vector<Pose> poses_;                    // per body
  std::vector<std::vector<double>> speeds_;    // per robot, per joint
  /// [body][i]: how far any point of the body can move by its joints from the i-th on.
  std::vector<std::vector<double>> suffix_;
};

}  // namespace handover::verify
