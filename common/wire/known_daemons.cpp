// SPDX-License-Identifier: Apache-2.0
#include "wire/known_daemons.hpp"

#include "wire/codec.hpp"

#include <algorithm>
#include <variant>

namespace handover::wire {

void KnownDaemons::take(const Sample<msg::DaemonStatus>& sample) {
  if (sample.message == nullptr) return lose(sample.writer);
  const auto decoded = decode(*sample.message);
  const auto* status = std::get_if<DaemonStatus>(&decoded);
  if (status == nullptr) return;
  const bool taken = std::any_of(by_writer_.begin(), by_writer_.end(), [&](const auto& entry) {
    return entry.first != sample.writer && entry.second.id == status->id;
  });
  if (!taken) by_writer_[sample.writer] = *status;
}

void KnownDaemons::lose(const Guid& writer) { by_writer_.erase(writer); }

bool KnownDaemons::announced(const Guid& entity) const {
  return std::any_of(by_writer_.begin(), by_writer_.end(),
                     [&](const auto& entry) { return sameParticipant(entry.first, entity); });
}

bool KnownDaemons::anyServes(const std::string& cell) const {
  const auto daemons = all();
  return std::any_of(daemons.begin(), daemons.end(),
                     [&](const DaemonStatus& daemon) { return serves(daemon, cell); });
}

std::vector<DaemonStatus> KnownDaemons::all() const {
  std::vector<DaemonStatus> all;
  for (const auto& [writer, status] : by_writer_) {
    if (status.state != DaemonState::kStopping) all.push_back(status);
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return all;
}

}  // namespace handover::wire
