// SPDX-License-Identifier: Apache-2.0
#include "dds/client_stream.hpp"

#include "runtime/thread_name.hpp"
#include "wire/codec.hpp"

#include <handover/common/log.hpp>

namespace handover {
namespace {

using namespace std::chrono_literals;

/// Answered requests that are kept at most: half of what the writer can hold.
constexpr std::size_t kAnswered = 128;

msg::PlanEvent keyOnly(const RequestId& id) {
  msg::PlanEvent message;
  message.request_id(id.bytes);
  return message;
}

}  // namespace

ClientStream::ClientStream(const wire::Participant& participant, std::string client_id,
                           Settings settings, std::function<void()> on_drop)
    : participant_(participant),
      client_id_(std::move(client_id)),
      settings_(settings),
      on_drop_(std::move(on_drop)),
      thread_([this] { loop(); }) {}

ClientStream::~ClientStream() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
}

void ClientStream::publish(const PlanEvent& event) {
  {
    const MutexLock lock(mutex_);
    last_used_ = Clock::now();
    if (dropped_) return;
    if (backlog_.size() >= settings_.max_backlog) {
      dropped_ = true;
      backlog_.clear();
    } else {
      backlog_.push_back(event);
    }
  }
  changed_.notify_all();
}

bool ClientStream::idle() const {
  const MutexLock lock(mutex_);
  return backlog_.empty() && instances_ == 0 && Clock::now() - last_used_ > settings_.retention;
}

void ClientStream::flush(Clock::time_point until) {
  MutexLock lock(mutex_);
  flush_wanted_ = true;
  changed_.notify_all();
  changed_.wait_until(lock, until, [this]() HANDOVER_REQUIRES(mutex_) {
    return !flush_wanted_ || dropped_ || stopping_;
  });
}

// The stream's thread.

void ClientStream::loop() noexcept {
  nameThread("to " + client_id_);
  try {
    run();
  } catch (const std::exception& error) {
    logger("dds")->error("client {}: {}", client_id_, error.what());
    const MutexLock lock(mutex_);
    dropped_ = true;
    backlog_.clear();
  }
  bool drop = false;
  {
    const MutexLock lock(mutex_);
    drop = dropped_ && !stopping_;
    instances_ = 0;
  }
  changed_.notify_all();
  if (drop) {
    logger("dds")->warn("client {} does not keep up and is dropped", client_id_);
    on_drop_();
  }
}

void ClientStream::run() {
  wire::Writer<msg::PlanEvent> writer(participant_, {.partition = client_id_});
  while (true) {
    std::deque<PlanEvent> batch;
    {
      MutexLock lock(mutex_);
      const auto wake = [this]() HANDOVER_REQUIRES(mutex_) {
        return stopping_ || dropped_ || flush_wanted_ || !backlog_.empty();
      };
      if (flush_wanted_ && backlog_.empty()) {
        // Only when asked: events that came meanwhile would wait for the acknowledgement.
        lock.unlock();
        const bool all = writer.waitForAcknowledgments(50ms);
        lock.lock();
        if (all && backlog_.empty()) {
          flush_wanted_ = false;
          changed_.notify_all();
        }
      } else if (answered_.empty()) {
        changed_.wait(lock, wake);
      } else {
        changed_.wait_until(lock, answered_.front().at + settings_.retention, wake);
      }
      if (stopping_ || dropped_) return;
      batch.swap(backlog_);
    }
    for (const PlanEvent& event : batch) {
      if (send(writer, event)) continue;
      const MutexLock lock(mutex_);
      dropped_ = true;
      return;
    }
    forget(writer, Clock::now());
  }
}

bool ClientStream::send(wire::Writer<msg::PlanEvent>& writer, const PlanEvent& event) {
  if (event.sequence == 0) {
    if (answered_.size() >= kAnswered) {
      writer.waitForAcknowledgments(1s);  // what is forgotten is not sent again
      forget(writer, Clock::time_point::max());
    }
    const MutexLock lock(mutex_);
    ++instances_;
  }
  // One try blocks for the writer's blocking time; the client's lease is longer than that.
  for (int attempt = 0; attempt < 5; ++attempt) {
    const auto result = writer.write(wire::encode(event));
    if (result == wire::WriteResult::kOk) {
      if (std::holds_alternative<Outcome>(event.payload)) {
        writer.dispose(keyOnly(event.request_id));
        answered_.push_back({event.request_id, Clock::now()});
      }
      return true;
    }
    if (result == wire::WriteResult::kError) return false;
    const MutexLock lock(mutex_);
    if (stopping_) return false;
  }
  return false;
}

void ClientStream::forget(wire::Writer<msg::PlanEvent>& writer, Clock::time_point now) {
  // A full writer forgets the older half of its answers before their time: not one by one, or each
  // request from then on would wait for the acknowledgement, which takes up to a heartbeat.
  const bool full = now == Clock::time_point::max();
  while (!answered_.empty() && (full ? answered_.size() > kAnswered / 2
                                     : now - answered_.front().at >= settings_.retention)) {
    writer.unregister(keyOnly(answered_.front().id));
    answered_.pop_front();
    const MutexLock lock(mutex_);
    --instances_;
  }
}

}  // namespace handover
