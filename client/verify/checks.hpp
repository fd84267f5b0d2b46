// SPDX-License-Identifier: Apache-2.0
// The checks, in the order in which they are made.
#pragma once

#include "verify/motion.hpp"
#include "verify/order.hpp"
#include "verify/report.hpp"
#include "verify/rules.hpp"
#include "verify/scene.hpp"

#include <set>
#include <tuple>

namespace handover::verify {

/// Kinds `start`, `mimic`, `limits`, `scene`: q_start within limits and by the mimic laws, limits
/// no wider than URDF and yaml say, objects where they are said to be.
void checkStart(const Scene& scene, Report& report);

/// Kinds `chain`, `stages`, `samples`, `joints`, `overlap`: holders, hands, the list of stages,
/// what each may move.
/// @returns false when the stages have no meaning together, so that nothing further can be checked.
bool checkStructure(const Scene& scene, Report& report);

/// Kinds `position`, `velocity`, `acceleration`, `jerk`, `join`, `stop`, `home`: every curve
/// against the limits, where stages begin and end.
void checkTrajectories(const Motion& motion, Report& report);
/// The greatest |jerk| / limit of all curves.
double jerkShare(const Scene& scene);

/// Kind `order`: edges, starts. Late and in-turn contacts are checkLate() and checkContacts().
/// @returns false when the edges contradict one another.
bool checkOrder(const Motion& motion, Report& report);

/// Kind `holding`: what is in hand as each stage begins.
void checkHolding(const Motion& motion, Report& report);
/// Kind `state`: O's way from start to goal without a jump.
void checkState(const Motion& motion, Report& report);
/// Kind `upright`. @returns the greatest tilt beyond the larger of start and goal [deg], at least
/// 0.
double checkUpright(const Motion& motion, Report& report);
/// Kind `straight`.
void checkStraight(const Motion& motion, Report& report);
/// Fills Task::first_5mm and hand_leaves. @param motion at the planned starts, of that task.
void findLeaving(const Motion& motion, Task& task);

/// Kind `rest`: what O stands on at start and goal.
void checkRests(const Motion& motion, const std::set<int>& start_rests,
                const std::set<int>& goal_rests, Report& report);

/// Kind `grip`.
void checkGrips(const Motion& motion, Report& report);

/// Kind `dexterity`.
void checkDexterity(const Motion& motion, Report& report);

/// Kind `may_touch`: the file's claims.
void checkClaims(const Motion& motion, const ContactRules& rules, Report& report);

/// Pairs of bodies that were reported already.
using ReportedPairs = std::set<std::pair<int, int>>;

/// Kinds `contact`, `depth`: every pair at q_start, then along the whole motion.
void checkContacts(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
                   Report& report);
/// Kind `order`: one stage after the other. Only pairs that two actors move against each other: all
/// others meet as they do in the plan.
void checkContactsInTurn(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
                         Report& report);
/// Kind `order`: all starts that are late by up to slack_s.
void checkContactsLate(const Motion& motion, const ContactRules& rules, ReportedPairs& reported,
                       Report& report);

/// Kind `quality`: measures, and compares with the file's claims where it has some. Clearances are
/// measured when they are claimed or `all` is asked for.
void checkQuality(const Motion& motion, const ContactRules& rules, double tilt_deg, bool all,
                  Report& report);

/// sqrt(det(J Jᵀ)) where the holder takes, gives.
double dexterityAtTake(const Motion& motion, int holder);
double dexterityAtGive(const Motion& motion, int holder);
/// When it takes: the start of its grasp, 0 if it has O; when it gives: the start of its release,
/// or the end of the last carry.
double takeTime(const Motion& motion, int holder);
double giveTime(const Motion& motion, int holder);

/// O's tilt-free numbers in text: "0.0123".
std::string text(double value);

}  // namespace handover::verify
