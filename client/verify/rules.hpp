// SPDX-License-Identifier: Apache-2.0
// Which contacts are lawful: pairs that never count, and those that follow from where O is.
#pragma once

#include "verify/motion.hpp"
#include "verify/scene.hpp"

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace handover::verify {

constexpr double kRestDepth = 1e-3;  // [m] that O may be deep in what it rests on
constexpr double kHandDepth = 2e-3;  // [m] that a hand may be deep in O

/// What O may touch at some moment.
struct Allowances {
  std::vector<bool> hand;  ///< per holder
  bool start_rest = false, goal_rest = false;
};

struct Window {
  double from = 0, to = 0;  ///< [s]

  bool overlaps(double begin, double end) const {
    return std::min(to, end) - std::max(from, begin) > kTimeTolerance;
  }

  static constexpr double kTimeTolerance = 1e-9;
};

/// When O may touch the holder's hand: from the start of its grasp until, in its retreat, it is 5
/// mm away (or the next carry may start).
Window handWindow(const Motion& motion, int holder);
/// When O may touch what it rests on at the start, at the goal.
Window startRestWindow(const Motion& motion);
Window goalRestWindow(const Motion& motion);

Allowances allowancesAt(const Motion& motion, double T);

class ContactRules {
 public:
  /// `start_rests`, `goal_rests`: objects in Plan::objects.
  ContactRules(const Scene& scene, const std::set<int>& start_rests,
               const std::set<int>& goal_rests);

  /// Pairs never tested: links joined by a joint (through fixed ones), SRDF pairs, attachments with
  /// their touch_links, resting pairs.
  bool standing(int body_a, int body_b) const {
    return standing_[static_cast<std::size_t>(body_a) * bodies_ + static_cast<std::size_t>(body_b)];
  }

  /// How deep the two may be in one another; nullopt: they must not touch.
  std::optional<double> depthAllowed(const Allowances& allowances, int body_a, int body_b) const;

  /// For the file's claims, by name: links without geometry are named there, too.
  bool standing(const std::string& a, const std::string& b) const {
    return standing_names_.count({a, b}) > 0;
  }

  bool mayTouch(const Allowances& allowances, const std::string& a, const std::string& b) const;

 private:
  const Scene& scene_;
  std::size_t bodies_;
  std::vector<bool> standing_;
  std::set<NamePair> standing_names_;              ///< both ways round
  std::vector<std::vector<int>> hands_of_;         ///< per body: holders whose hand it belongs to
  std::set<int> start_rests_, goal_rests_;         ///< objects
  std::vector<std::set<std::string>> hand_names_;  ///< per holder
};

/// The objects that O may touch where it starts, or at the goal: those of the file's `rest`, or of
/// "none" all that are within 2 mm of O there.
std::set<int> startRests(const Motion& motion);
std::set<int> goalRests(const Motion& motion);

}  // namespace handover::verify
