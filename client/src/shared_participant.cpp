// SPDX-License-Identifier: Apache-2.0
#include "shared_participant.hpp"

#include <handover/common/mutex.hpp>

#include <map>

namespace handover::client {
namespace {

struct Shared {
  Mutex mutex;
  std::map<int, std::weak_ptr<const wire::Participant>> by_domain HANDOVER_GUARDED_BY(mutex);
};

/// Never destroyed: clients may be static, too.
Shared& shared() {
  static Shared& only = *new Shared;
  return only;
}

}  // namespace

std::shared_ptr<const wire::Participant> sharedParticipant(int domain) {
  Shared& all = shared();
  const MutexLock lock(all.mutex);
  std::weak_ptr<const wire::Participant>& known = all.by_domain[domain];
  auto participant = known.lock();
  if (participant == nullptr) {
    participant = std::make_shared<const wire::Participant>(
        wire::ParticipantOptions{.domain = domain, .name = "handover client", .on_writer = {}});
    known = participant;
  }
  return participant;
}

}  // namespace handover::client
