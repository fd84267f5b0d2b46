// SPDX-License-Identifier: Apache-2.0
#include "wire/known_daemons.hpp"

#include "wire/codec.hpp"

#include <algorithm>
#include <variant>

namespace handover::wire {

void KnownDaemons::take(const Sample<msg::DaemonStatus>& sample) {
  if (sample.message == nullptr) {
    daemons_.erase(sample.key);
    return;
  }
  const auto decoded = decode(*sample.message);
  const auto* status = std::get_if<DaemonStatus>(&decoded);
  if (status == nullptr) return;
  if (status->state == DaemonState::kStopping) {
    daemons_.erase(status->id);
  } else {
    daemons_[status->id] = {sample.writer, *status};
  }
}

void KnownDaemons::lose(const Guid& writer) {
  std::erase_if(daemons_, [&](const auto& entry) { return entry.second.first == writer; });
}

bool KnownDaemons::anyServes(const std::string& cell) const {
  return std::any_of(daemons_.begin(), daemons_.end(),
                     [&](const auto& entry) { return serves(entry.second.second, cell); });
}

std::vector<DaemonStatus> KnownDaemons::all() const {
  std::vector<DaemonStatus> all;
  for (const auto& [id, entry] : daemons_) all.push_back(entry.second);
  return all;
}

}  // namespace handover::wire
