// SPDX-License-Identifier: Apache-2.0
// A daemon's claims to lead cells, on the wire.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/mutex.hpp>
#include <handover/common/status.hpp>

#include <map>
#include <vector>

namespace handover {

/// One writer a claim, as strong as its epoch. Safe from any thread but Fast DDS's.
class ClaimWriters {
 public:
  explicit ClaimWriters(const wire::Participant& participant) : participant_(participant) {}

  /// Claims a cell, or says again that it does. False when it could not.
  bool write(const Claim& claim);
  /// The others hear that the claim has ended.
  void end(const CellKey& cell);

 private:
  struct Held {
    Claim claim;
    wire::Writer<msg::Leader> writer;
  };

  const wire::Participant& participant_;
  Mutex mutex_;
  /// The newest last; one before it ends when the newest is there for a while, so that the cell
  /// does not look free between them.
  std::map<CellKey, std::vector<Held>> held_ HANDOVER_GUARDED_BY(mutex_);
};

}  // namespace handover
