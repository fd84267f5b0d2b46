// SPDX-License-Identifier: Apache-2.0
// Which daemons are there, by the status topic.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/status.hpp>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace handover::wire {

/// The daemons that serve or are about to. A status writer stands for one daemon, and a daemon for
/// one writer, its participant's latest: who else claims its id is not believed while that one is
/// there. Not synchronised: its owner's lock guards it.
class KnownDaemons {
 public:
  /// Takes a daemon's latest status. What cannot be read is passed over.
  void take(const Sample<msg::DaemonStatus>& sample);

  /// Forgets the daemon whose status writer was lost.
  void lose(const Guid& writer);

  /// True when the entity is of a participant that announced a daemon, stopping ones included.
  bool announced(const Guid& entity) const;

  bool empty() const { return size() == 0; }

  std::size_t size() const;

  /// True when one of them serves that cell.
  bool anyServes(const std::string& cell) const;

  /// The latest statuses of those that do not stop, by id.
  std::vector<DaemonStatus> all() const;

 private:
  std::map<Guid, DaemonStatus> by_writer_;
};

}  // namespace handover::wire
