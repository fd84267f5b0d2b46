// SPDX-License-Identifier: Apache-2.0
#include "cells/nearest_fix.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <tuple>
#include <utility>

namespace handover {
namespace {

constexpr double kStep = 0.05;                   // [m]
constexpr double kTurn = std::numbers::pi / 18;  // [rad]
constexpr double kMetresPerRadian = 0.5;
constexpr int kTurns = 36;  // of kTurn in a circle

/// Roll, pitch and yaw [rad] about fixed axes, x first.
Eigen::Vector3d rpyOf(const Eigen::Matrix3d& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

std::string numbers(const char* format, double a, double b, double c) {
  char text[128];
  std::snprintf(text, sizeof(text), format, a + 0.0, b + 0.0, c + 0.0);
  return text;
}

/// Adds the moves in the plane that bring a ball's centre so near to another ball that they meet.
void addPlaces(const Eigen::Vector3d& centre, double radius, const ReachBall& to,
               std::vector<std::pair<int, int>>& places) {
  const Eigen::Vector3d offset = to.p_WShoulder - centre;
  const double both = radius + to.radius;
  if (std::abs(offset.z()) > both) return;
  const double near = std::sqrt(both * both - offset.z() * offset.z());
  const auto low = [&](double at) { return static_cast<int>(std::ceil((at - near) / kStep)); };
  const auto high = [&](double at) { return static_cast<int>(std::floor((at + near) / kStep)); };
  for (int i = low(offset.x()); i <= high(offset.x()); ++i) {
    for (int j = low(offset.y()); j <= high(offset.y()); ++j) {
      if (std::hypot(kStep * i - offset.x(), kStep * j - offset.y()) <= near) {
        places.emplace_back(i, j);
      }
    }
  }
}

/// One search for a fix: what was asked, and what came of it.
class FixSearch {
 public:
  FixSearch(const SceneRobot& receiver, const FixQuestions& questions, std::uint64_t most_work)
      : receiver_(receiver), questions_(questions), most_work_(most_work) {}

  NearestFix over(const std::vector<BaseMove>& moves) {
    std::size_t failed_promise = 0;
    if (moves.empty()) ended();
    for (const BaseMove& move : moves) {
      if (looked_ == kMostMapLooks || ended()) break;
      ++looked_;
      const std::size_t promise = questions_.promise(overrideOf(move, receiver_));
      if (promise == 0) continue;
      if (promise <= failed_promise) {
        passed_over_.push_back(&move);
        continue;
      }
      if (plans(move)) return found(move);
      failed_promise = promise;
    }
    for (const BaseMove* move : passed_over_) {
      if (ended()) break;
      if (plans(*move)) return found(*move);
    }
    return notFound();
  }

 private:
  bool ended() {
    if (planned_ == kMostFixPlans || work_ >= most_work_) return true;
    if (stopped_.empty()) stopped_ = questions_.stop();
    return !stopped_.empty();
  }

  bool plans(const BaseMove& move) {
    if (ended()) return false;
    ++planned_;
    return questions_.plans(overrideOf(move, receiver_), work_);
  }

  std::string tried() const {
    return "of " + std::to_string(looked_) + " nearer moves that were looked at in the maps, " +
           std::to_string(planned_) + " were planned";
  }

  NearestFix found(const BaseMove& move) const {
    return {{overrideOf(move, receiver_)},
            "There is a plan with " + receiver_.name +
                numbers(" moved by (%.2f, %.2f) m and turned by %.0f degrees; ", kStep * move.i,
                        kStep * move.j, 10.0 * move.turn) +
                tried() + "."};
  }

  NearestFix notFound() const {
    if (looked_ == 0 && !stopped_.empty()) return {{}, "Not sought: " + stopped_ + "."};
    const std::string why = stopped_.empty() ? "" : "; then " + stopped_;
    return {
        {},
        "No move of " + receiver_.name + " that was tried gives a plan: " + tried() + why + "."};
  }

  const SceneRobot& receiver_;
  const FixQuestions& questions_;
  const std::uint64_t most_work_;
  std::uint64_t work_ = 0;
  std::uint32_t looked_ = 0, planned_ = 0;
  std::string stopped_;
  std::vector<const BaseMove*> passed_over_;  ///< promised something, by rising cost
};

}  // namespace

double BaseMove::cost() const {
  return kStep * std::hypot(i, j) + kMetresPerRadian * kTurn * std::abs(turn);
}

std::vector<BaseMove> movesByCost(const Eigen::Vector3d& p_WB, const std::vector<ReachBall>& moved,
                                  const std::vector<ReachBall>& other, std::size_t most,
                                  const Deadline& deadline) {
  std::vector<std::pair<double, BaseMove>> moves;
  std::vector<std::pair<int, int>> places;
  for (int turn = 1 - kTurns / 2; turn <= kTurns / 2; ++turn) {
    if (deadline.over()) return {};
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(kTurn * turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    places.clear();
    for (const ReachBall& ball : moved) {
      const Eigen::Vector3d turned = p_WB + R * (ball.p_WShoulder - p_WB);
      for (const ReachBall& to : other) addPlaces(turned, ball.radius, to, places);
    }
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    for (const auto& [i, j] : places) {
      const BaseMove move{i, j, turn};
      if (move != BaseMove{}) moves.emplace_back(move.cost(), move);
    }
  }
  const auto cheaper = [](const auto& a, const auto& b) {
    const auto key = [](const auto& entry) {
      const BaseMove& move = entry.second;
      return std::tuple(entry.first, move.turn, move.i, move.j);
    };
    return key(a) < key(b);
  };
  const std::size_t size = std::min(most, moves.size());
  std::partial_sort(moves.begin(), moves.begin() + static_cast<std::ptrdiff_t>(size), moves.end(),
                    cheaper);
  std::vector<BaseMove> sorted;
  sorted.reserve(size);
  for (std::size_t i = 0; i < size; ++i) sorted.push_back(moves[i].second);
  return sorted;
}

Override overrideOf(const BaseMove& move, const SceneRobot& robot) {
  const Eigen::Vector3d p = robot.X_WB.translation() + kStep * Eigen::Vector3d(move.i, move.j, 0);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(kTurn * move.turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d degrees = rpyOf(turn * robot.X_WB.linear()) * (180 / std::numbers::pi);
  return {"robots." + robot.name + ".base",
          numbers("{xyz: [%.6g, %.6g, %.6g], ", p.x(), p.y(), p.z()) +
              numbers("rpy_deg: [%.6g, %.6g, %.6g]}", degrees.x(), degrees.y(), degrees.z())};
}

NearestFix findNearestFix(const SceneRobot& receiver, const std::vector<BaseMove>& moves,
                          const FixQuestions& questions, std::uint64_t most_work) {
  return FixSearch(receiver, questions, most_work).over(moves);
}

}  // namespace handover
