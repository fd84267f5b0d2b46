// SPDX-License-Identifier: Apache-2.0
#include "cells/nearest_fix.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <tuple>

namespace handover {
namespace {

constexpr double kStep = 0.05;                   // [m]
constexpr double kTurn = std::numbers::pi / 18;  // [rad]
constexpr double kMetresPerRadian = 0.5;
constexpr int kTurns = 36;  // of kTurn in a circle
constexpr std::uint32_t kPlans = 200;
constexpr std::uint32_t kMapLooks = 20'000;

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

/// Moves in the plane that bring a ball's centre so near to another ball that they meet.
void addPlaces(const Eigen::Vector3d& centre, double radius, const ReachBall& to,
               std::set<std::pair<int, int>>& places) {
  const Eigen::Vector3d offset = to.p_WShoulder - centre;
  const double both = radius + to.radius;
  if (std::abs(offset.z()) > both) return;
  const double near = std::sqrt(both * both - offset.z() * offset.z());
  const auto low = [&](double at) { return static_cast<int>(std::ceil((at - near) / kStep)); };
  const auto high = [&](double at) { return static_cast<int>(std::floor((at + near) / kStep)); };
  for (int i = low(offset.x()); i <= high(offset.x()); ++i) {
    for (int j = low(offset.y()); j <= high(offset.y()); ++j) {
      if (std::hypot(kStep * i - offset.x(), kStep * j - offset.y()) <= near) places.emplace(i, j);
    }
  }
}

std::string tried(std::uint32_t looked, std::uint32_t planned) {
  return std::to_string(looked) + " nearer place(s) were ruled out by the maps, " +
         std::to_string(planned) + " planned without success";
}

}  // namespace

double BaseMove::cost() const {
  return kStep * std::hypot(i, j) + kMetresPerRadian * kTurn * std::abs(turn);
}

std::vector<BaseMove> movesByCost(const Eigen::Vector3d& p_WB, const std::vector<ReachBall>& moved,
                                  const std::vector<ReachBall>& other) {
  std::vector<std::pair<double, BaseMove>> moves;
  for (int turn = 1 - kTurns / 2; turn <= kTurns / 2; ++turn) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(kTurn * turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    std::set<std::pair<int, int>> places;
    for (const ReachBall& ball : moved) {
      const Eigen::Vector3d turned = p_WB + R * (ball.p_WShoulder - p_WB);
      for (const ReachBall& to : other) addPlaces(turned, ball.radius, to, places);
    }
    for (const auto& [i, j] : places) {
      const BaseMove move{i, j, turn};
      if (move != BaseMove{}) moves.emplace_back(move.cost(), move);
    }
  }
  std::sort(moves.begin(), moves.end(), [](const auto& a, const auto& b) {
    const auto key = [](const auto& entry) {
      const BaseMove& move = entry.second;
      return std::tuple(entry.first, move.turn, move.i, move.j);
    };
    return key(a) < key(b);
  });
  std::vector<BaseMove> sorted;
  sorted.reserve(moves.size());
  for (const auto& [cost, move] : moves) sorted.push_back(move);
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
                          const std::function<bool(const Override&)>& maps_allow,
                          const std::function<bool(const Override&)>& plans,
                          const Deadline& deadline) {
  std::uint32_t ruled_out = 0, planned = 0;
  for (const BaseMove& move : moves) {
    if (deadline.over()) {
      return {{},
              "The deadline passed while moves of " + receiver.name +
                  " were tried: " + tried(ruled_out, planned) + "."};
    }
    if (planned >= kPlans || ruled_out >= kMapLooks) break;
    const Override change = overrideOf(move, receiver);
    if (!maps_allow(change)) {
      ++ruled_out;
      continue;
    }
    if (plans(change)) {
      return {{change},
              "There is a plan with " + receiver.name +
                  numbers(" moved by (%.2f, %.2f) m and turned by %.0f degrees; ", kStep * move.i,
                          kStep * move.j, 10.0 * move.turn) +
                  tried(ruled_out, planned) + "."};
    }
    ++planned;
  }
  return {{},
          "No move of " + receiver.name +
              " that was tried gives a plan: " + tried(ruled_out, planned) + "."};
}

}  // namespace handover
