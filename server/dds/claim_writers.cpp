// SPDX-License-Identifier: Apache-2.0
#include "dds/claim_writers.hpp"

#include "wire/codec.hpp"

#include <handover/common/log.hpp>

namespace handover {

bool ClaimWriters::write(const Claim& claim) {
  const MutexLock lock(mutex_);
  std::vector<Held>& held = held_[claim.cell];
  try {
    if (held.empty() || held.back().claim != claim) {
      const auto strength = static_cast<std::uint32_t>(claim.epoch);
      held.push_back({claim, wire::Writer<msg::Leader>(participant_, {.strength = strength})});
    } else if (held.size() > 1) {
      held.erase(held.begin());
    }
    return held.back().writer.write(wire::encode(claim)) == wire::WriteResult::kOk;
  } catch (const wire::DdsError& error) {
    logger("dds")->error("a cell cannot be claimed: {}", error.what());
    return false;
  }
}

void ClaimWriters::end(const CellKey& cell) {
  const MutexLock lock(mutex_);
  const auto found = held_.find(cell);
  if (found == held_.end()) return;
  for (Held& held : found->second) held.writer.dispose(wire::encode(held.claim));
  held_.erase(found);
}

}  // namespace handover
