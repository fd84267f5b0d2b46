// SPDX-License-Identifier: Apache-2.0
// Which requests are this daemon's to answer, where several serve the same cells.
#pragma once

#include "runtime/election.hpp"
#include "runtime/endpoint.hpp"

#include <handover/common/mutex.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace handover {

/// What daemons do that serve the same cell.
enum class CellSharing {
  kStandby,  ///< one of them leads and answers, the others wait to follow it
  kShared,   ///< each answers every request
};

/// Stands for the cells that are served, on a thread of its own: claims them, follows other
/// daemons' claims and has kept requests offered when it has won one. Methods are safe from any
/// thread; what it calls is called from its thread, without a lock.
class Leadership {
 public:
  using Clock = Election::Clock;

  struct Settings {
    DaemonId id{};
    CellSharing sharing = CellSharing::kStandby;
    ElectionTimes times;
  };

  struct Calls {
    /// The names of the cells that are served.
    std::function<std::vector<std::string>()> served;
    /// Other daemons lead these cells now: answers that have begun are given up.
    std::function<void(const std::vector<std::string>& cells)> lost;
    /// It is certain what we lead: outcomes that were held back can go.
    std::function<void()> certain;
    /// Roles are others now.
    std::function<void()> changed;
  };

  /// @pre the endpoint outlives it.
  Leadership(Endpoint& endpoint, const Settings& settings, Calls calls);

  ~Leadership() { stop(); }

  Leadership(const Leadership&) = delete;
  Leadership& operator=(const Leadership&) = delete;

  void start();
  /// Gives every claim up: others follow at once.
  void stop();

  /// Another daemon claims a cell, or gave its claim up.
  void heard(const Claim& claim);
  void ended(const Claim& claim);

  enum class Whose { kOurs, kOthers, kNobodys };
  /// Of a cell that we serve. @param epoch  with which we lead it, where it is ours; 0: shared.
  Whose whoseServed(const std::string& cell, std::uint64_t& epoch) const;
  /// Of a request for a cell that we do not serve. One that was kept may be for a daemon that comes
  /// back: it is that one's for as long as clients wait.
  Whose whoseUnserved(const std::string& cell, bool kept) const;

  /// We reject what is nobody's: of the daemons that are there, the one of lowest id does.
  bool rejects() const { return rejects(endpoint_.others()); }

  /// Whether we lead a cell for certain, with that epoch; 0: it is shared.
  bool leads(const std::string& cell, std::uint64_t epoch) const;
  /// False: as we slept or could not claim, others may lead what we led.
  bool certain() const;
  /// Fills in role and epoch.
  void tellRoles(std::vector<CellInfo>& cells) const;

 private:
  void loop() noexcept;
  /// Claims, follows and gives up cells. True when that changed what is ours.
  bool takeTurn();
  /// Stands for the cells that are served. @return those that are not any more.
  std::vector<std::string> standFor(const std::vector<std::string>& cells, Clock::time_point now)
      HANDOVER_REQUIRES(mutex_);
  void noteServedByOthers(const std::vector<DaemonStatus>& others, Clock::time_point now)
      HANDOVER_REQUIRES(mutex_);
  /// Tells the other daemons, the owner and the log. False: a claim could not be written.
  bool announce(const Election::Turn& turn);
  /// Notes until when what we lead is ours. True when it is so again.
  bool renew(const Election::Turn& turn, bool claimed, Clock::time_point now);
  bool rejects(const std::vector<DaemonStatus>& others) const;
  bool leadsNow(const std::string& cell, std::uint64_t epoch) const HANDOVER_REQUIRES(mutex_);

  Endpoint& endpoint_;
  const Settings settings_;
  const Calls calls_;
  const Clock::time_point began_at_ = Clock::now();

  mutable Mutex mutex_;
  Condition wake_;  // a claim ended, or stop()
  Election election_ HANDOVER_GUARDED_BY(mutex_);
  std::vector<std::string> stands_for_ HANDOVER_GUARDED_BY(mutex_);
  /// Nobody else can lead the cells that we lead before then.
  Clock::time_point leads_until_ HANDOVER_GUARDED_BY(mutex_) = Clock::time_point::min();
  std::map<std::string, Clock::time_point> served_by_others_ HANDOVER_GUARDED_BY(mutex_);
  bool claim_ended_ HANDOVER_GUARDED_BY(mutex_) = false;
  bool stopping_ HANDOVER_GUARDED_BY(mutex_) = false;

  std::jthread thread_;
};

}  // namespace handover
