// SPDX-License-Identifier: Apache-2.0
// Where requests come from and answers go to: DDS in the daemon, memory in tests.
#pragma once

#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <chrono>
#include <string>
#include <vector>

namespace handover {

/// Takes what clients send. Methods return at once and are called from the endpoint's threads,
/// never two at a time.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  /// A request whose fields passed check(). False: it is another daemon's to answer, or asked again
  /// while it is being answered; true: it gets an outcome.
  virtual bool onRequest(const PlanRequest& request) = 0;
  /// A request that did not; its id and client are readable all the same. As onRequest(); the
  /// daemon of lowest id answers.
  virtual bool onInvalidRequest(const RequestId& id, const std::string& client_id,
                                const std::vector<Fault>& faults) = 0;
  /// The client cancelled the request, disposed it or is gone, as `cause` says.
  virtual void onCancel(const RequestId& id, CancelCause cause) = 0;
};

/// Methods are safe from any thread, open() and stopReceiving() from the owner's.
class Endpoint {
 public:
  virtual ~Endpoint() = default;

  /// Starts to deliver to `handler`, which outlives stopReceiving().
  virtual void open(RequestHandler& handler) = 0;
  /// No call of the handler runs or starts after this returned.
  virtual void stopReceiving() = 0;

  /// Sends an event to a client, in order per request. Never waits for a client.
  virtual void publish(const std::string& client_id, const PlanEvent& event) = 0;
  /// Announces this daemon; counts of clients and refusals are the endpoint's to fill in. Called at
  /// least every two seconds.
  virtual void publishStatus(const DaemonStatus& status) = 0;
  /// The other daemons announced and alive.
  virtual std::vector<DaemonStatus> others() const = 0;
  /// Waits until clients have what was published, or the time is over.
  virtual void flush(std::chrono::milliseconds most) = 0;
};

}  // namespace handover
