// SPDX-License-Identifier: Apache-2.0
// Who leads a cell, of the daemons that serve it: decided by each for itself, from what it hears
// and its own clock.
#pragma once

#include <handover/common/status.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace handover {

/// The same for every daemon of a domain.
struct ElectionTimes {
  std::chrono::milliseconds lease{500};    ///< a leader that was not heard for this long is gone
  std::chrono::milliseconds period{125};   ///< from one claim of a leader to its next
  std::chrono::milliseconds settle{500};   ///< a daemon listens before it claims a free cell
  std::chrono::milliseconds stagger{150};  ///< left to each daemon that goes before us
  std::chrono::milliseconds hush{50};      ///< from a first claim to leading: others may claim too
  /// A daemon that slept for this long, and those that did not, may have lost each other: a little
  /// less than the time after which a silent participant is lost.
  std::chrono::milliseconds lost{2500};
  std::chrono::milliseconds found{3000};  ///< at most, until they have found each other again
};

/// XXH128 of the name, most significant byte first.
CellKey cellKey(const std::string& name);

/// A daemon leads a cell while it claims it. A standby claims it, with the highest epoch seen plus
/// one, when the leader has given it up or was not heard for the lease, those of lower id first. Of
/// two that claim, the one with the lower epoch steps back; with the same, the one with the higher
/// id, and the other takes another epoch. One that slept hears first whether it was followed, or
/// who leads. Not safe from several threads; times never go back.
class Election {
 public:
  using Clock = std::chrono::steady_clock;

  Election(const DaemonId& self, const ElectionTimes& times) : self_(self), times_(times) {}

  /// The cells that it stands for from now on.
  void stand(const std::vector<std::string>& cells, Clock::time_point now);
  /// Another daemon's claim came.
  void heard(const Claim& claim, Clock::time_point now);
  /// The other daemon gave its claim up.
  void ended(const Claim& claim, Clock::time_point now);

  /// The other daemons that serve a cell and do not share it.
  using Peers = std::function<std::vector<DaemonId>(const std::string& cell)>;

  /// What is to be done now.
  struct Turn {
    std::vector<std::string> won, lost;
    std::vector<Claim> claims;  ///< to be written: each cell that we lead, when its time has come
    /// Nobody else can lead what we lead before then, once the claims are written; none: as we
    /// slept, we do not know yet whether somebody does.
    std::optional<Clock::time_point> leads_until;
  };

  /// To be called several times in each period.
  Turn turn(Clock::time_point now, const Peers& peers);

  /// kUndecided for a cell that it does not stand for.
  CellRole roleOf(const std::string& cell) const;
  /// Of the cell's leader, us or another; 0: none is known.
  std::uint64_t epochOf(const std::string& cell) const;

 private:
  struct Rival {
    Claim claim;
    Clock::time_point heard_at;
  };

  struct Cell {
    std::string name;
    std::optional<std::uint64_t> epoch;               ///< that we claim it with
    bool leading = false;                             ///< nobody has contradicted
    std::uint64_t highest = 0;                        ///< epoch seen
    std::optional<Rival> rival;                       ///< the strongest that was heard
    Clock::time_point free_at;                        ///< without a leader: when it may be claimed
    Clock::time_point claimed_at;                     ///< for the last time
    std::optional<Clock::time_point> in_doubt_until;  ///< others may have claimed it
  };

  bool alive(const Cell& cell, Clock::time_point now) const;
  void wake(Cell& cell, Clock::time_point now, Clock::duration slept) const;
  void claim(Cell& cell, Clock::time_point now, Turn& turn) const;
  void claimAnew(Cell& cell, Clock::time_point now, Turn& turn) const;
  bool stepsBack(Cell& cell, Clock::time_point now, Turn& turn) const;
  void lead(Cell& cell, Clock::time_point now, const Peers& peers, Turn& turn) const;
  void follow(Cell& cell, Clock::time_point now, const Peers& peers, Turn& turn) const;
  Clock::time_point claimTime(const Cell& cell, const Peers& peers) const;
  const Cell* find(const std::string& name) const;

  const DaemonId self_;
  const ElectionTimes times_;
  std::map<CellKey, Cell> cells_;
  std::optional<Clock::time_point> turned_at_;
};

}  // namespace handover
