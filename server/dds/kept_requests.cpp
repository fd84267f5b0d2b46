// SPDX-License-Identifier: Apache-2.0
#include "dds/kept_requests.hpp"

#include <algorithm>
#include <utility>

namespace handover {

void KeptRequests::keep(const RequestId& id, Kept kept) {
  forget(id);
  bytes_ += kept.bytes;
  entries_[id] = {next_place_++, std::move(kept)};
  while (entries_.size() > most_ || bytes_ > most_bytes_) forget(surplus());
}

KeptRequests::Kept* KeptRequests::find(const RequestId& id) {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second.kept;
}

std::optional<KeptRequests::Kept> KeptRequests::take(const RequestId& id) {
  Kept* found = find(id);
  if (found == nullptr) return std::nullopt;
  Kept taken = std::move(*found);
  forget(id);
  return taken;
}

void KeptRequests::forget(const RequestId& id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  bytes_ -= found->second.kept.bytes;
  entries_.erase(found);
}

void KeptRequests::loseWriter(const wire::Guid& writer, Clock::time_point now) {
  lost_.emplace(writer, now);
}

void KeptRequests::regainWriter(const wire::Guid& writer) { lost_.erase(writer); }

void KeptRequests::forgetLost(Clock::time_point before) {
  const auto gone = [&](const wire::Guid& writer) {
    const auto found = lost_.find(writer);
    return found != lost_.end() && found->second < before;
  };
  std::vector<RequestId> over;
  for (const auto& [id, entry] : entries_) {
    if (gone(entry.kept.writer)) over.push_back(id);
  }
  for (const RequestId& id : over) forget(id);
  std::erase_if(lost_, [&](const auto& each) { return each.second < before; });
}

std::vector<RequestId> KeptRequests::ids() const {
  std::vector<std::pair<std::uint64_t, RequestId>> places;
  for (const auto& [id, entry] : entries_) {
    if (!lost_.contains(entry.kept.writer)) places.emplace_back(entry.place, id);
  }
  std::sort(places.begin(), places.end());
  std::vector<RequestId> ids;
  for (const auto& [place, id] : places) ids.push_back(id);
  return ids;
}

RequestId KeptRequests::surplus() const {
  std::map<std::string, std::size_t> held;
  for (const auto& [id, entry] : entries_) held[entry.kept.client_id] += 1 + entry.kept.bytes;
  const auto rank = [&](const auto& item) {
    const Entry& entry = item.second;
    return std::pair(held[entry.kept.client_id], ~entry.place);
  };
  return std::max_element(entries_.begin(), entries_.end(),
                          [&](const auto& a, const auto& b) { return rank(a) < rank(b); })
      ->first;
}

}  // namespace handover
