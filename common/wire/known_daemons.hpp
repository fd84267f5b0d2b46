// SPDX-License-Identifier: Apache-2.0
// Which daemons are there, by the status topic.
#pragma once

#include "wire/entities.hpp"

#include <handover/common/status.hpp>

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace handover::wire {

/// The daemons that serve or are about to. Not synchronised: its owner's lock guards it.
class KnownDaemons {
 public:
  /// Takes a daemon's latest status; forgets one that is stopping or whose status has ended. What
  /// cannot be read is passed over.
  void take(const Sample<msg::DaemonStatus>& sample);

  /// Forgets the daemon whose status writer was lost.
  void lose(const Guid& writer);

  bool empty() const { return daemons_.empty(); }

  std::size_t size() const { return daemons_.size(); }

  /// True when one of them serves that cell.
  bool anyServes(const std::string& cell) const;

  /// Their latest statuses, by id.
  std::vector<DaemonStatus> all() const;

 private:
  std::map<DaemonId, std::pair<Guid, DaemonStatus>> daemons_;
};

}  // namespace handover::wire
