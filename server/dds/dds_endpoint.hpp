// SPDX-License-Identifier: Apache-2.0
// The daemon's endpoint on DDS: requests, cancels and status in the default partition, events in
// one partition, writer and thread per client.
#pragma once

#include "runtime/endpoint.hpp"

#include <memory>

namespace handover {

struct DdsEndpointSettings {
  int domain = 0;
  /// Answered requests stay readable for late joiners this long.
  std::chrono::milliseconds retention = std::chrono::seconds(60);
  std::size_t max_clients =
      256;  ///< at a time; requests of more are ignored with a word to the log
  std::size_t max_backlog = 16384;  ///< events waiting for one client; more drop the client
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
  void flush(std::chrono::milliseconds most) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handover
