// SPDX-License-Identifier: Apache-2.0
#include "runtime/election.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace handover {

CellKey cellKey(const std::string& name) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(name.data(), name.size()));
  CellKey key;
  static_assert(sizeof(key) == sizeof(canonical.digest));
  std::memcpy(key.data(), canonical.digest, key.size());
  return key;
}

void Election::stand(const std::vector<std::string>& cells, Clock::time_point now) {
  std::map<CellKey, Cell> standing;
  for (const std::string& name : cells) {
    const CellKey key = cellKey(name);
    if (const auto found = cells_.find(key); found != cells_.end()) {
      standing[key] = std::move(found->second);
    } else {
      standing[key].name = name;
      standing[key].free_at = now + times_.settle;
    }
  }
  cells_ = std::move(standing);
}

bool Election::alive(const Cell& cell, Clock::time_point now) const {
  return cell.rival && now - cell.rival->heard_at < times_.lease;
}

void Election::heard(const Claim& claim, Clock::time_point now) {
  const auto found = cells_.find(claim.cell);
  if (found == cells_.end() || claim.daemon == self_) return;
  Cell& cell = found->second;
  cell.highest = std::max(cell.highest, claim.epoch);
  if (alive(cell, now) && cell.rival->claim.daemon != claim.daemon) {
    const Claim& known = cell.rival->claim;
    const bool stronger =
        claim.epoch != known.epoch ? claim.epoch > known.epoch : claim.daemon < known.daemon;
    if (!stronger) return;
  }
  cell.rival = Rival{claim, now};
}

void Election::ended(const Claim& claim, Clock::time_point now) {
  const auto found = cells_.find(claim.cell);
  if (found == cells_.end()) return;
  Cell& cell = found->second;
  if (!cell.rival || cell.rival->claim != claim) return;
  cell.rival.reset();
  cell.free_at = now;
}

Election::Turn Election::turn(Clock::time_point now, const Peers& peers) {
  const auto slept = now - turned_at_.value_or(now);
  turned_at_ = now;
  Turn turn;
  turn.leads_until = Clock::time_point::max();
  for (auto& [key, cell] : cells_) {
    if (slept > times_.lease / 2) wake(cell, now, slept);
    if (cell.epoch) {
      lead(cell, now, peers, turn);
    } else {
      follow(cell, now, peers, turn);
    }
  }
  for (const auto& [key, cell] : cells_) {
    if (!cell.leading || !turn.leads_until) continue;
    turn.leads_until = std::min(*turn.leads_until, cell.claimed_at + times_.lease);
    if (cell.in_doubt_until) turn.leads_until.reset();
  }
  return turn;
}

/// What others said meanwhile has not been heard yet: everybody has another chance. Where they may
/// have lost each other, the leader is silent until it must have been found; those that would
/// follow it wait longer.
void Election::wake(Cell& cell, Clock::time_point now, Clock::duration slept) const {
  const bool lost = slept >= times_.lost;
  const auto heard_at = lost ? now + times_.found : now;
  if (lost && cell.epoch) {
    cell.rival.reset();
    cell.in_doubt_until = heard_at;
  } else if (cell.in_doubt_until) {
    cell.in_doubt_until = std::max(*cell.in_doubt_until, now + 2 * times_.period);
  }
  if (cell.rival) cell.rival->heard_at = std::max(cell.rival->heard_at, heard_at);
  cell.free_at = std::max(cell.free_at, heard_at + times_.lease);
}

void Election::claim(Cell& cell, Clock::time_point now, Turn& turn) const {
  cell.claimed_at = now;
  turn.claims.push_back({cellKey(cell.name), self_, *cell.epoch});
}

void Election::claimAnew(Cell& cell, Clock::time_point now, Turn& turn) const {
  cell.epoch = cell.highest = std::min(cell.highest + 1, kMostEpoch);
  claim(cell, now, turn);
}

/// Before a stronger claim of another, after a sleep before any: one that came new does not know
/// our epoch. One as strong is answered with a stronger one.
bool Election::stepsBack(Cell& cell, Clock::time_point now, Turn& turn) const {
  if (!alive(cell, now)) return false;
  const bool followed = cell.leading && cell.in_doubt_until;
  if (cell.rival->claim.epoch < *cell.epoch && !followed) return false;
  if (!followed && cell.rival->claim.epoch == *cell.epoch && self_ < cell.rival->claim.daemon) {
    claimAnew(cell, now, turn);
    return false;
  }
  if (cell.leading) turn.lost.push_back(cell.name);
  cell.epoch.reset();
  cell.leading = false;
  cell.in_doubt_until.reset();
  return true;
}

void Election::lead(Cell& cell, Clock::time_point now, const Peers& peers, Turn& turn) const {
  if (now - cell.claimed_at >= times_.lease && !cell.in_doubt_until && !peers(cell.name).empty()) {
    cell.in_doubt_until = now + 2 * times_.period;
    cell.rival.reset();
  }
  if (stepsBack(cell, now, turn)) return;
  if (cell.leading && cell.in_doubt_until && now < *cell.in_doubt_until) return;
  if (cell.in_doubt_until && now >= *cell.in_doubt_until) {
    cell.in_doubt_until.reset();
    if (!cell.leading) turn.won.push_back(cell.name);
    cell.leading = true;
  }
  if (now - cell.claimed_at >= times_.period) claim(cell, now, turn);
}

void Election::follow(Cell& cell, Clock::time_point now, const Peers& peers, Turn& turn) const {
  if (alive(cell, now) || now < claimTime(cell, peers)) return;
  cell.rival.reset();
  cell.in_doubt_until = now + times_.hush;
  claimAnew(cell, now, turn);
}

/// Those of lower id claim first, but for the leader that is gone.
Election::Clock::time_point Election::claimTime(const Cell& cell, const Peers& peers) const {
  const auto serving = peers(cell.name);
  const auto before = std::count_if(serving.begin(), serving.end(), [&](const DaemonId& peer) {
    return peer < self_ && !(cell.rival && cell.rival->claim.daemon == peer);
  });
  const auto free_at = cell.rival ? cell.rival->heard_at + times_.lease : cell.free_at;
  return free_at + before * times_.stagger;
}

const Election::Cell* Election::find(const std::string& name) const {
  const auto found = cells_.find(cellKey(name));
  return found == cells_.end() ? nullptr : &found->second;
}

CellRole Election::roleOf(const std::string& cell) const {
  const Cell* found = find(cell);
  if (found == nullptr) return CellRole::kUndecided;
  if (found->leading) return CellRole::kLeader;
  return found->rival ? CellRole::kStandby : CellRole::kUndecided;
}

std::uint64_t Election::epochOf(const std::string& cell) const {
  const Cell* found = find(cell);
  if (found == nullptr) return 0;
  if (found->epoch) return *found->epoch;
  return found->rival ? found->rival->claim.epoch : 0;
}

}  // namespace handover
