// SPDX-License-Identifier: Apache-2.0
// Writes requests and reads events without our client library.
#pragma once

#include "process.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <vector>

namespace handover::test {

class BareClient {
 public:
  BareClient(int domain, const std::string& client_id)
      : participant_({.domain = domain, .name = "bare", .on_writer = {}}),
        events_(participant_, {.partition = client_id},
                [this](const wire::Sample<msg::PlanEvent>& sample) {
                  if (sample.message == nullptr) return;
                  const auto event = wire::decode(*sample.message);
                  const std::lock_guard lock(mutex_);
                  received_.push_back(std::get<PlanEvent>(event));
                  changed_.notify_all();
                }),
        requests_(participant_, {.on_match = [this](const auto&) {
                    const std::lock_guard lock(mutex_);
                    changed_.notify_all();
                  }}) {}

  /// Once `readers` have matched.
  void send(const msg::HandoverRequest& request, int readers = 1) {
    {
      std::unique_lock lock(mutex_);
      ASSERT_TRUE(changed_.wait_for(lock, 20s, [&] { return requests_.matched() >= readers; }));
    }
    ASSERT_EQ(requests_.write(request), wire::WriteResult::kOk);
  }

  void dispose(const msg::HandoverRequest& request) { requests_.dispose(request); }

  bool waitForEvents(std::size_t count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 20s, [&] { return received_.size() >= count; });
  }

  std::optional<Outcome> outcome() {
    std::unique_lock lock(mutex_);
    const auto ended = [this] {
      return !received_.empty() && std::holds_alternative<Outcome>(received_.back().payload);
    };
    if (!changed_.wait_for(lock, 20s, ended)) return std::nullopt;
    return std::get<Outcome>(received_.back().payload);
  }

  std::vector<PlanEvent> events() {
    const std::lock_guard lock(mutex_);
    return received_;
  }

  /// Waits until one of the events is what is asked for.
  template <typename Test>
  bool waitFor(Test test) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 20s,
                             [&] { return std::any_of(received_.begin(), received_.end(), test); });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<PlanEvent> received_;
  wire::Participant participant_;
  wire::Reader<msg::PlanEvent> events_;
  wire::Writer<msg::HandoverRequest> requests_;
};

}  // namespace handover::test
