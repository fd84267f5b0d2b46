// SPDX-License-Identifier: Apache-2.0
// Writes the daemon's status for months.
#pragma once

#include "wire/entities.hpp"

#include <cstdint>
#include <optional>

namespace handover {

/// Goes on with a new writer now and then: who finds one walks from sample 0 to its first one that
/// is still there, and packet guards take a far one for a hostile one (see packet_guard.cpp). The
/// last writer stays until the next status, so that readers always see one. One thread at a time.
class StatusWriter {
 public:
  /// @param most  statuses of one writer. @throws wire::DdsError.
  StatusWriter(const wire::Participant& participant, std::uint64_t most);

  [[nodiscard]] wire::WriteResult write(const msg::DaemonStatus& status);

 private:
  const wire::Participant& participant_;
  const std::uint64_t most_;
  std::uint64_t written_ = 0;
  std::optional<wire::Writer<msg::DaemonStatus>> last_, current_;
};

}  // namespace handover
