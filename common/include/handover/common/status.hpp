// SPDX-License-Identifier: Apache-2.0
// What a daemon tells about itself.
#pragma once

#include <handover/common/enum_names.hpp>
#include <handover/common/request_id.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace handover {

/// What an experiment draws for one override path: evenly between two ends, or one of some choices.
struct Variation {
  std::string path;
  std::vector<double> from, to;  ///< the ends, of the same size; one entry: a plain number
  /// For rpy_deg ranges: the drawn yaw is added to the direction from the place, which varies too
  /// (the same path's xyz), to this (x, y).
  std::optional<std::array<double, 2>> facing;
  std::vector<std::string> choices;  ///< YAML values; empty for a range
  bool operator==(const Variation&) const = default;
};

/// For the path of a range that faces a point: the path of its place.
std::string placePath(const Variation& facing);

/// What a daemon is to a cell that it serves.
enum class CellRole {
  kUndecided = 0,  ///< it has just come and listens who leads
  kLeader,         ///< it answers the cell's requests
  kStandby,        ///< another daemon does; this one takes over when that one ends
  kShared,         ///< it answers them, whoever else does
};

template <>
struct EnumNames<CellRole> {
  static constexpr std::array value{"undecided", "leader", "standby", "shared"};
};

/// A cell that a daemon serves.
struct CellInfo {
  std::string name;
  std::vector<std::string> tasks;
  std::uint64_t revision = 0;         ///< of its scene
  std::vector<Variation> variations;  ///< what experiments draw, in the cell file's order
  std::string scene_hash{};           ///< of the first task, before overrides; hex digits, or none
  CellRole role = CellRole::kUndecided;
  std::uint64_t epoch = 0;  ///< of the cell's leader; 0: none is known, or the cell is shared
  bool operator==(const CellInfo&) const = default;
};

/// A daemon's random id, made at its start; lower ids answer for cells that nobody serves.
using DaemonId = std::array<std::uint8_t, 16>;

/// A hash of a cell's name.
using CellKey = std::array<std::uint8_t, 16>;

/// A daemon's word that it leads a cell.
struct Claim {
  CellKey cell{};
  DaemonId daemon{};
  std::uint64_t epoch = 0;  ///< 1 to kMostEpoch
  bool operator==(const Claim&) const = default;
};

inline constexpr std::uint64_t kMostEpoch = 0xffff'ffff;

enum class DaemonState {
  kUnspecified = 0,
  kPreparing,  ///< builds maps and grasp sets; requests wait in the queue
  kReady,
  kStopping,  ///< open requests get their outcomes, new ones are left to others
};

template <>
struct EnumNames<DaemonState> {
  static constexpr std::array value{"unspecified", "preparing", "ready", "stopping"};
};

/// Requests answered since the start, by outcome.
struct OutcomeCounters {
  std::uint64_t accepted = 0;
  std::uint64_t done = 0, failed = 0, cancelled = 0, rejected = 0;
  bool operator==(const OutcomeCounters&) const = default;
};

/// How long answers took, from taking a request to its outcome.
struct AnswerTimes {
  double median_ms = 0, p95_ms = 0;
  bool operator==(const AnswerTimes&) const = default;
};

/// Answered requests that a status names, at most.
inline constexpr std::size_t kMostAnswered = 1024;

struct DaemonStatus {
  DaemonId id{};
  std::string version;
  DaemonState state = DaemonState::kUnspecified;
  std::vector<CellInfo> cells;
  std::uint32_t queued = 0, running = 0;
  OutcomeCounters counters;
  std::uint64_t refused = 0;          ///< requests that could not even be answered
  std::uint32_t clients = 0;          ///< that have a stream of events
  std::uint64_t memory_bytes = 0;     ///< resident; 0: not known
  std::uint64_t dropped_packets = 0;  ///< datagrams that would have ended or frozen the daemon
  double uptime_s = 0;
  std::optional<AnswerTimes> answer_times;  ///< of the last answers that were planned
  std::uint32_t kept_requests = 0;          ///< of other daemons, for the case that they end
  /// That have their outcome and were not disposed yet: nobody else is to answer them.
  std::vector<RequestId> answered;
  bool operator==(const DaemonStatus&) const = default;
};

/// True when the cell is among the daemon's.
bool serves(const DaemonStatus& daemon, std::string_view cell);

}  // namespace handover
