// SPDX-License-Identifier: Apache-2.0
// The daemon's endpoint on DDS: requests, cancels and status in the default partition, events in a
// partition per client. A client costs a writer, no thread, and nothing before a request of its is
// ours, but that writers are made ahead for the last few that showed up.
#pragma once

#include "runtime/endpoint.hpp"

#include <memory>

namespace handover {

struct DdsEndpointSettings {
  int domain = 0;
  /// Answers stay readable for late joiners this long, unless their client has confirmed them.
  std::chrono::milliseconds retention = std::chrono::seconds(60);
  // Of clients without an open request, last used first:
  std::size_t most_idle = 64;          ///< that have confirmed their answers or not yet asked
  std::size_t most_unconfirmed = 256;  ///< in all
  std::size_t most_bytes = 64 << 20;   ///< of events held for them
  std::uint64_t statuses = 65'536;     ///< written by one writer; an hour at least
};

class DdsEndpoint : public Endpoint {
 public:
  /// Joins the domain. @throws wire::DdsError.
  explicit DdsEndpoint(const DdsEndpointSettings& settings);
  ~DdsEndpoint() override;

  void open(RequestHandler& handler) override;
  void stopReceiving() override;
  void publish(const std::string& client_id, const PlanEvent& event) override;
  void publishStatus(const DaemonStatus& status) override;
  std::vector<DaemonStatus> others() const override;
  bool claim(const Claim& claim) override;
  void giveUp(const CellKey& cell) override;
  void offerKept() override;
  void handBack(const PlanRequest& request) override;
  void flush(std::chrono::milliseconds most) override;

  /// True when a question from a second participant of this process, which comes and is answered
  /// over the sockets, got its answer within `most`, and no receiving thread hangs. Takes no
  /// worker. One thread at a time; the process delivers over sockets only (see
  /// wire::deliverOverSockets()). @throws wire::DdsError.
  bool reachable(std::chrono::milliseconds most);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handover
