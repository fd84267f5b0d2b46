// SPDX-License-Identifier: Apache-2.0
// Asks a participant over the sockets, as a client would from outside.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/mutex.hpp>

#include <chrono>
#include <cstdint>

namespace handover {

/// A participant of its own beside the one that it asks. One thread at a time.
class Prober {
 public:
  /// @throws wire::DdsError.
  Prober(int domain, const wire::Guid& target);

  /// Asks until an answer comes: true. False after `most`.
  bool probe(std::chrono::milliseconds most);

 private:
  const wire::Guid target_;
  Mutex mutex_;
  Condition changed_;
  std::uint64_t answered_ HANDOVER_GUARDED_BY(mutex_) = 0;  ///< the last one that was
  std::uint64_t asked_ = 0;

  // Last: their callbacks use all above.
  wire::Participant participant_;
  wire::Reader<msg::Probe> answers_;
  wire::Writer<msg::Probe> questions_;
};

}  // namespace handover
