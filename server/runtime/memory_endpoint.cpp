// SPDX-License-Identifier: Apache-2.0
#include "runtime/memory_endpoint.hpp"

namespace handover {

void MemoryEndpoint::open(RequestHandler& handler) {
  const MutexLock lock(delivering_);
  handler_ = &handler;
}

void MemoryEndpoint::stopReceiving() {
  const MutexLock lock(delivering_);
  handler_ = nullptr;
}

void MemoryEndpoint::publish(const std::string&, const PlanEvent& event) {
  const MutexLock lock(mutex_);
  events_[event.request_id].push_back(event);
  changed_.notify_all();
}

void MemoryEndpoint::publishStatus(const DaemonStatus& status) {
  const MutexLock lock(mutex_);
  status_ = status;
  changed_.notify_all();
}

bool MemoryEndpoint::claim(const Claim&) { return true; }

void MemoryEndpoint::giveUp(const CellKey&) {}

void MemoryEndpoint::offerKept() {
  const MutexLock lock(delivering_);
  if (handler_ == nullptr) return;
  std::erase_if(kept_, [this](const auto& kept) HANDOVER_REQUIRES(delivering_) {
    return handler_->onRequest(kept.second, true) != Verdict::kPerhaps;
  });
}

void MemoryEndpoint::handBack(const PlanRequest& request) {
  const MutexLock lock(delivering_);
  kept_[request.id] = request;
}

void MemoryEndpoint::hearClaim(const Claim& claim) {
  const MutexLock lock(delivering_);
  if (handler_ != nullptr) handler_->onClaim(claim);
}

void MemoryEndpoint::endClaim(const Claim& claim) {
  const MutexLock lock(delivering_);
  if (handler_ != nullptr) handler_->onClaimEnded(claim);
}

std::vector<DaemonStatus> MemoryEndpoint::others() const {
  const MutexLock lock(mutex_);
  return others_;
}

void MemoryEndpoint::send(const PlanRequest& request) {
  const MutexLock lock(delivering_);
  if (handler_ == nullptr) return;
  if (handler_->onRequest(request, false) == Verdict::kPerhaps) kept_[request.id] = request;
}

void MemoryEndpoint::sendInvalid(const RequestId& id, const std::string& client_id,
                                 const std::vector<Fault>& faults) {
  const MutexLock lock(delivering_);
  if (handler_ != nullptr) handler_->onInvalidRequest(id, client_id, faults);
}

void MemoryEndpoint::cancel(const RequestId& id, CancelCause cause) {
  const MutexLock lock(delivering_);
  if (handler_ != nullptr) handler_->onCancel(id, cause);
}

void MemoryEndpoint::announceOther(const DaemonStatus& status) {
  const MutexLock lock(mutex_);
  others_.push_back(status);
}

std::vector<PlanEvent> MemoryEndpoint::events(const RequestId& id) const {
  const MutexLock lock(mutex_);
  const auto found = events_.find(id);
  return found == events_.end() ? std::vector<PlanEvent>{} : found->second;
}

std::optional<std::vector<PlanEvent>> MemoryEndpoint::waitFor(
    const RequestId& id, const std::function<bool(const std::vector<PlanEvent>&)>& condition,
    std::chrono::milliseconds most) const {
  MutexLock lock(mutex_);
  std::vector<PlanEvent> seen;
  const bool met = changed_.wait_for(lock, most, [&]() HANDOVER_REQUIRES(mutex_) {
    const auto found = events_.find(id);
    if (found == events_.end() || !condition(found->second)) return false;
    seen = found->second;
    return true;
  });
  if (!met) return std::nullopt;
  return seen;
}

std::optional<Outcome> MemoryEndpoint::outcome(const RequestId& id) const {
  const auto ended = [](const std::vector<PlanEvent>& events) {
    return std::holds_alternative<Outcome>(events.back().payload);
  };
  const auto seen = waitFor(id, ended);
  if (!seen) return std::nullopt;
  return std::get<Outcome>(seen->back().payload);
}

bool MemoryEndpoint::waitForStatus(const std::function<bool(const DaemonStatus&)>& condition,
                                   std::chrono::milliseconds most) const {
  MutexLock lock(mutex_);
  return changed_.wait_for(
      lock, most, [&]() HANDOVER_REQUIRES(mutex_) { return status_ && condition(*status_); });
}

}  // namespace handover
