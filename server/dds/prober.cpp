// SPDX-License-Identifier: Apache-2.0
#include "dds/prober.hpp"

#include <algorithm>

namespace handover {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

Prober::Prober(int domain, const wire::Guid& target)
    : target_(target),
      participant_({.domain = domain, .name = "handoverd probe", .on_writer = {}}),
      answers_(participant_, {},
               [this](const wire::Sample<msg::Probe>& sample) {
                 const msg::Probe* probe = sample.message;
                 if (probe == nullptr || !probe->answer() || probe->participant() != target_ ||
                     !wire::sameParticipant(sample.writer, target_)) {
                   return;
                 }
                 const MutexLock lock(mutex_);
                 answered_ = std::max(answered_, probe->count());
                 changed_.notify_all();
               }),
      questions_(participant_, {}) {}

bool Prober::probe(std::chrono::milliseconds most) {
  const auto until = Clock::now() + most;
  msg::Probe question;
  question.version(msg::WIRE_VERSION);
  question.participant(target_);
  question.count(++asked_);
  const auto answered = [this]() HANDOVER_REQUIRES(mutex_) { return answered_ >= asked_; };
  while (Clock::now() < until) {
    // Asked again and again: what is written before both have matched is lost.
    (void)questions_.write(question);
    MutexLock lock(mutex_);
    if (changed_.wait_until(lock, std::min(until, Clock::now() + 100ms), answered)) return true;
  }
  return false;
}

}  // namespace handover
