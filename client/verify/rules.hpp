// SPDX-License-Identifier: Apache-2.0
// The contract's stage table: who holds O in which stage, what may touch, which pairs never count.
#pragma once

#include "verify/motion.hpp"
#include "verify/scene.hpp"

#include <set>
#include <string>
#include <utility>
#include <vector>

namespace handover::verify {

/// Whether the giver (receiver) holds O during the whole of a stage.
bool giverHolds(int stage);
bool receiverHolds(int stage);
bool isGiverStage(int stage);
/// grasp and release: the fingers move; else the arm.
bool isHandStage(int stage);

/// Contacts as the table has them, worked out from the scene alone.
class ContactRules {
 public:
  /// `goal_rest`: names of the objects that O is to rest on.
  ContactRules(const Scene& scene, std::set<std::string> goal_rest);

  /// Pairs never tested: links joined by a joint (through fixed ones), SRDF Adjacent and Always,
  /// attachments with their touch_links, resting pairs. O's own rests are not among them: the table
  /// lets O touch its rest while it is grasped and lifted, not when it is carried past later.
  bool standing(int body_a, int body_b) const;

  /// What a stage's row adds: always O and something. `in_first_5mm`: of a retreat's motion.
  bool mayTouch(int stage, bool in_first_5mm, int body_a, int body_b) const;
  /// The same by name, for the file's claims: links without geometry are named there too.
  bool mayTouch(int stage, bool in_first_5mm, const std::string& a, const std::string& b) const;
  bool standing(const std::string& a, const std::string& b) const;

 private:
  const Scene& scene_;
  std::set<std::string> giver_hand_, receiver_hand_, start_rest_, goal_rest_;
  std::set<NamePair> standing_;  ///< both ways round
};

/// What O is to rest on: every other object that O would meet 2 mm below the goal pose and is clear
/// of 2 mm above it. The plan file does not say it; so small a gap carries O, and a body that still
/// touches O when that is raised is one that O is stuck in, not one that it rests on.
std::set<std::string> goalRests(const Motion& motion);

}  // namespace handover::verify
