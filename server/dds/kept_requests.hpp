// SPDX-License-Identifier: Apache-2.0
// Requests that other daemons are to answer, kept for the case that they end.
#pragma once

#include "wire/codec.hpp"
#include "wire/entities.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace handover {

/// Bounded: where the most is held, the client that holds most loses its oldest one; it asks again
/// when nobody answers. Not safe from several threads.
///
/// A request writer that is lost may come back: a daemon that slept takes everybody for gone, and
/// Fast DDS does not deliver again to a reader what it had from a writer that it lost so. What a
/// lost writer asked for stays, but nobody is to answer it before the writer is back.
class KeptRequests {
 public:
  using Clock = std::chrono::steady_clock;

  struct Kept {
    std::string client_id;
    wire::Guid writer{};
    wire::Decoded<PlanRequest> request;
    std::size_t bytes = 0;  ///< about what it takes
    std::optional<CancelCause> cancelled{};
  };

  explicit KeptRequests(std::size_t most = 4096, std::size_t most_bytes = 16 << 20)
      : most_(most), most_bytes_(most_bytes) {}

  /// In place of what was kept under the id.
  void keep(const RequestId& id, Kept kept);
  /// Null: it is not kept.
  Kept* find(const RequestId& id);
  std::optional<Kept> take(const RequestId& id);
  /// Its outcome is there, or nobody wants it any more.
  void forget(const RequestId& id);

  void loseWriter(const wire::Guid& writer, Clock::time_point now);
  void regainWriter(const wire::Guid& writer);
  /// Forgets the writers that were lost before then, and what they asked for.
  void forgetLost(Clock::time_point before);

  /// Those whose writers are there, as they came.
  std::vector<RequestId> ids() const;

  std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    std::uint64_t place = 0;
    Kept kept;
  };

  /// The oldest of the client that holds most.
  RequestId surplus() const;

  const std::size_t most_, most_bytes_;
  std::map<RequestId, Entry> entries_;
  std::map<wire::Guid, Clock::time_point> lost_;  ///< writers, and since when
  std::size_t bytes_ = 0;
  std::uint64_t next_place_ = 0;
};

}  // namespace handover
