// SPDX-License-Identifier: Apache-2.0
#include "runtime/leadership.hpp"

#include "runtime/thread_name.hpp"

#include <handover/common/log.hpp>

#include <algorithm>
#include <utility>

namespace handover {
namespace {

using namespace std::chrono_literals;

/// Several times within the period of claims.
constexpr auto kTurnPeriod = 25ms;

/// Kept requests are looked at again this often: those of clients that came back, and those of
/// daemons that did not.
constexpr auto kOfferPeriod = 1s;

/// A daemon that went may come back: requests that were for it are rejected after this time.
/// Clients of ours give up before.
constexpr auto kReturnTime = 6s;

/// @param others  outlive what is returned
Election::Peers peersOf(const std::vector<DaemonStatus>& others) {
  return [&others](const std::string& cell) {
    std::vector<DaemonId> serving;
    for (const DaemonStatus& other : others) {
      for (const CellInfo& info : other.cells) {
        if (info.name == cell && info.role != CellRole::kShared) serving.push_back(other.id);
      }
    }
    return serving;
  };
}

}  // namespace

Leadership::Leadership(Endpoint& endpoint, const Settings& settings, Calls calls)
    : endpoint_(endpoint),
      settings_(settings),
      calls_(std::move(calls)),
      election_(settings.id, settings.times) {}

void Leadership::start() {
  thread_ = std::jthread([this] { loop(); });
}

void Leadership::stop() {
  std::vector<std::string> cells;
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
    cells.swap(stands_for_);
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
  for (const std::string& cell : cells) endpoint_.giveUp(cellKey(cell));
}

void Leadership::heard(const Claim& claim) {
  const MutexLock lock(mutex_);
  election_.heard(claim, Clock::now());
}

void Leadership::ended(const Claim& claim) {
  {
    const MutexLock lock(mutex_);
    election_.ended(claim, Clock::now());
    claim_ended_ = true;
  }
  wake_.notify_all();
}

Leadership::Whose Leadership::whoseServed(const std::string& cell, std::uint64_t& epoch) const {
  epoch = 0;
  if (settings_.sharing == CellSharing::kShared) return Whose::kOurs;
  const MutexLock lock(mutex_);
  epoch = election_.epochOf(cell);
  return epoch > 0 && leadsNow(cell, epoch) ? Whose::kOurs : Whose::kOthers;
}

Leadership::Whose Leadership::whoseUnserved(const std::string& cell, bool kept) const {
  const auto others = endpoint_.others();
  const bool served = std::any_of(others.begin(), others.end(),
                                  [&](const auto& other) { return serves(other, cell); });
  if (served || !rejects(others)) return Whose::kOthers;
  if (!kept) return Whose::kNobodys;
  const MutexLock lock(mutex_);
  const auto found = served_by_others_.find(cell);
  const bool gone = found == served_by_others_.end() || Clock::now() - found->second >= kReturnTime;
  return gone ? Whose::kNobodys : Whose::kOthers;
}

/// A newcomer first hears who is there.
bool Leadership::rejects(const std::vector<DaemonStatus>& others) const {
  return Clock::now() - began_at_ >= settings_.times.settle &&
         std::all_of(others.begin(), others.end(),
                     [this](const DaemonStatus& other) { return settings_.id < other.id; });
}

bool Leadership::leads(const std::string& cell, std::uint64_t epoch) const {
  const MutexLock lock(mutex_);
  return leadsNow(cell, epoch);
}

bool Leadership::leadsNow(const std::string& cell, std::uint64_t epoch) const {
  return epoch == 0 || (election_.roleOf(cell) == CellRole::kLeader &&
                        election_.epochOf(cell) == epoch && Clock::now() < leads_until_);
}

bool Leadership::certain() const {
  const MutexLock lock(mutex_);
  return Clock::now() < leads_until_;
}

void Leadership::tellRoles(std::vector<CellInfo>& cells) const {
  const bool shared = settings_.sharing == CellSharing::kShared;
  const MutexLock lock(mutex_);
  for (CellInfo& cell : cells) {
    cell.role = shared ? CellRole::kShared : election_.roleOf(cell.name);
    cell.epoch = shared ? 0 : election_.epochOf(cell.name);
  }
}

// The thread.

std::vector<std::string> Leadership::standFor(const std::vector<std::string>& cells,
                                              Clock::time_point now) {
  if (cells == stands_for_) return {};
  std::vector<std::string> over;
  for (const std::string& cell : stands_for_) {
    if (std::find(cells.begin(), cells.end(), cell) == cells.end()) over.push_back(cell);
  }
  election_.stand(cells, now);
  stands_for_ = cells;
  return over;
}

void Leadership::noteServedByOthers(const std::vector<DaemonStatus>& others,
                                    Clock::time_point now) {
  for (const DaemonStatus& other : others) {
    for (const CellInfo& cell : other.cells) served_by_others_[cell.name] = now;
  }
  std::erase_if(served_by_others_,
                [&](const auto& served) { return now - served.second >= kReturnTime; });
}

bool Leadership::announce(const Election::Turn& turn) {
  bool claimed = true;
  for (const Claim& claim : turn.claims) claimed = endpoint_.claim(claim) && claimed;
  for (const std::string& cell : turn.won) logger("runtime")->info("leads cell {}", cell);
  if (turn.lost.empty()) return claimed;
  calls_.lost(turn.lost);
  for (const std::string& cell : turn.lost) {
    endpoint_.giveUp(cellKey(cell));
    logger("runtime")->warn("another daemon leads cell {}: its requests are left to it", cell);
  }
  return claimed;
}

bool Leadership::renew(const Election::Turn& turn, bool claimed, Clock::time_point now) {
  const MutexLock lock(mutex_);
  const auto until = turn.leads_until.value_or(Clock::time_point::min());
  const bool regained = claimed && now < until && now >= leads_until_;
  if (claimed || !turn.leads_until) leads_until_ = until;
  return regained;
}

bool Leadership::takeTurn() {
  const auto now = Clock::now();
  const auto others = endpoint_.others();
  const auto served = calls_.served();
  std::vector<std::string> over;
  Election::Turn turn;
  {
    const MutexLock lock(mutex_);
    if (stopping_) return false;
    noteServedByOthers(others, now);
    if (settings_.sharing == CellSharing::kStandby) over = standFor(served, now);
    turn = election_.turn(now, peersOf(others));
  }
  for (const std::string& cell : over) endpoint_.giveUp(cellKey(cell));
  const bool claimed = announce(turn);
  const bool regained = renew(turn, claimed, now);
  if (!turn.won.empty() || !turn.lost.empty()) calls_.changed();
  if (certain()) calls_.certain();
  return regained || !turn.won.empty();
}

void Leadership::loop() noexcept {
  nameThread("lead");
  auto offered_at = Clock::now();
  while (true) {
    const bool gained = takeTurn();
    if (gained || Clock::now() - offered_at >= kOfferPeriod) {
      endpoint_.offerKept();
      offered_at = Clock::now();
    }
    MutexLock lock(mutex_);
    wake_.wait_for(lock, kTurnPeriod,
                   [this]() HANDOVER_REQUIRES(mutex_) { return stopping_ || claim_ended_; });
    if (stopping_) return;
    claim_ended_ = false;
  }
}

}  // namespace handover
