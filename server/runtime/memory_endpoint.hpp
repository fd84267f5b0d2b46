// SPDX-License-Identifier: Apache-2.0
// The endpoint without a network: the daemon's tests put requests in and read events out.
#pragma once

#include "runtime/endpoint.hpp"

#include <handover/common/mutex.hpp>

#include <functional>
#include <map>
#include <optional>

namespace handover {

/// Safe from any thread.
class MemoryEndpoint : public Endpoint {
 public:
  void open(RequestHandler& handler) override;
  void stopReceiving() override;
  void publish(const std::string& client_id, const PlanEvent& event) override;
  void publishStatus(const DaemonStatus& status) override;
  std::vector<DaemonStatus> others() const override;
  bool claim(const Claim& claim) override;
  void giveUp(const CellKey& cell) override;
  void offerKept() override;
  void handBack(const PlanRequest& request) override;

  void flush(std::chrono::milliseconds) override {}

  // The client's side.
  void send(const PlanRequest& request);
  void sendInvalid(const RequestId& id, const std::string& client_id,
                   const std::vector<Fault>& faults);
  void cancel(const RequestId& id, CancelCause cause = CancelCause::kAsked);
  void announceOther(const DaemonStatus& status);
  void hearClaim(const Claim& claim);
  void endClaim(const Claim& claim);

  /// Events of a request so far, in the order of publishing.
  std::vector<PlanEvent> events(const RequestId& id) const;
  /// Waits until a request has events and they fulfil a condition; nullopt after `most`.
  std::optional<std::vector<PlanEvent>> waitFor(
      const RequestId& id, const std::function<bool(const std::vector<PlanEvent>&)>& condition,
      std::chrono::milliseconds most = std::chrono::seconds(20)) const;
  /// Waits until the last event of a request is an outcome.
  std::optional<Outcome> outcome(const RequestId& id) const;
  /// Waits until the last status fulfils a condition.
  bool waitForStatus(const std::function<bool(const DaemonStatus&)>& condition,
                     std::chrono::milliseconds most = std::chrono::seconds(20)) const;

 private:
  mutable Mutex mutex_;
  mutable Condition changed_;
  Mutex delivering_;  // held while the handler runs
  RequestHandler* handler_ HANDOVER_GUARDED_BY(delivering_) = nullptr;
  std::map<RequestId, PlanRequest> kept_ HANDOVER_GUARDED_BY(delivering_);
  std::map<RequestId, std::vector<PlanEvent>> events_ HANDOVER_GUARDED_BY(mutex_);
  std::vector<DaemonStatus> others_ HANDOVER_GUARDED_BY(mutex_);
  std::optional<DaemonStatus> status_ HANDOVER_GUARDED_BY(mutex_);
};

}  // namespace handover
