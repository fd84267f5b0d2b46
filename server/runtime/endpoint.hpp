// SPDX-License-Identifier: Apache-2.0
// Where requests come from and answers go to: DDS in the daemon, memory in tests.
#pragma once

#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <chrono>
#include <string>
#include <vector>

namespace handover {

/// What becomes of a request.
enum class Verdict {
  kMine,     ///< it gets an outcome
  kNotMine,  ///< it is being answered already
  kPerhaps,  ///< another daemon is to answer it, or it is not known yet who is: it is kept
};

/// Takes what clients send. Methods return at once and are called from the endpoint's threads, and
/// from who calls offerKept(), never two at a time.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  /// A request whose fields passed check(); `kept`: it was kept before.
  virtual Verdict onRequest(const PlanRequest& request, bool kept) = 0;
  /// A request that did not; its id and client are readable all the same.
  virtual Verdict onInvalidRequest(const RequestId& id, const std::string& client_id,
                                   const std::vector<Fault>& faults) = 0;
  /// The client cancelled the request, disposed it or is gone, as `cause` says.
  virtual void onCancel(const RequestId& id, CancelCause cause) = 0;
  /// Another daemon claims to lead a cell.
  virtual void onClaim(const Claim& claim) = 0;
  /// It gave that claim up.
  virtual void onClaimEnded(const Claim& claim) = 0;
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
  /// Claims a cell, or goes on to, in place of an earlier claim to it. False when it could not.
  virtual bool claim(const Claim& claim) = 0;
  /// Gives a claim up; the others hear of it.
  virtual void giveUp(const CellKey& cell) = 0;
  /// Hands every kept request to the handler again, in the order of their coming.
  virtual void offerKept() = 0;
  /// Keeps a request that the handler took; what was begun of its answer is given up, as far as it
  /// was not sent.
  virtual void handBack(const PlanRequest& request) = 0;
  /// Waits until clients have what was published, or the time is over.
  virtual void flush(std::chrono::milliseconds most) = 0;
};

}  // namespace handover
