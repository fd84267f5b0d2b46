// SPDX-License-Identifier: Apache-2.0
#include "wire/known_daemons.hpp"

#include "wire/codec.hpp"

#include <algorithm>
#include <variant>

namespace handover::wire {
namespace {

bool stays(const DaemonStatus& status) { return status.state != DaemonState::kStopping; }

}  // namespace

void KnownDaemons::take(const Sample<msg::DaemonStatus>& sample) {
  if (sample.message == nullptr) return lose(sample.writer);
  const auto decoded = decode(*sample.message);
  const auto* status = std::get_if<DaemonStatus>(&decoded);
  if (status == nullptr) return;
  // A participant may go on with another writer.
  std::erase_if(by_writer_, [&](const auto& entry) {
    return entry.second.id == status->id && sameParticipant(entry.first, sample.writer);
  });
  const bool taken = std::any_of(by_writer_.begin(), by_writer_.end(),
                                 [&](const auto& entry) { return entry.second.id == status->id; });
  if (!taken) by_writer_[sample.writer] = *status;
}

void KnownDaemons::lose(const Guid& writer) { by_writer_.erase(writer); }

bool KnownDaemons::announced(const Guid& entity) const {
  return std::any_of(by_writer_.begin(), by_writer_.end(),
                     [&](const auto& entry) { return sameParticipant(entry.first, entity); });
}

std::size_t KnownDaemons::size() const {
  return static_cast<std::size_t>(std::count_if(
      by_writer_.begin(), by_writer_.end(), [](const auto& entry) { return stays(entry.second); }));
}

bool KnownDaemons::anyServes(const std::string& cell) const {
  return std::any_of(by_writer_.begin(), by_writer_.end(), [&](const auto& entry) {
    return stays(entry.second) && serves(entry.second, cell);
  });
}

std::vector<DaemonStatus> KnownDaemons::all() const {
  std::vector<DaemonStatus> all;
  for (const auto& [writer, status] : by_writer_) {
    if (stays(status)) all.push_back(status);
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return all;
}

}  // namespace handover::wire
