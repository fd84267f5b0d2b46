// SPDX-License-Identifier: Apache-2.0
// Requests become answers: a bounded queue with fair turns for clients, workers, cancel, deadline,
// and exactly one outcome for each.
#pragma once

#include "runtime/client_accounts.hpp"
#include "runtime/endpoint.hpp"
#include "runtime/fair_queue.hpp"
#include "runtime/leadership.hpp"
#include "runtime/plan_service.hpp"
#include "runtime/recent_times.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/mutex.hpp>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace handover {

struct RuntimeSettings {
  int threads = 1;                   ///< workers, at least 1
  std::size_t queue_capacity = 256;  ///< requests waiting; more are rejected as busy
  std::size_t client_queue = 64;     ///< of one client
  ClientLimits client_limits;
  std::optional<double> deadline_s;  ///< of requests that name none
  std::size_t remembered = 4096;     ///< ids of answered requests, rejected when they come again
  DaemonId id{};
  std::string version;
  CellSharing sharing = CellSharing::kStandby;
  ElectionTimes election;
  /// Called once, from the preparing thread, when a cell cannot be prepared; requests fail from
  /// then on.
  std::function<void(const std::string&)> on_prepare_failed;
};

/// Owns the threads between endpoint and planning. Requests are accepted as soon as it leads their
/// cell. One thread makes what cells and single requests lack, so that a worker never does: a
/// request that has to wait for it holds up nobody else.
class Runtime : public RequestHandler {
 public:
  /// @pre service and endpoint outlive the runtime.
  Runtime(PlanService& service, Endpoint& endpoint, RuntimeSettings settings);
  ~Runtime() override;  ///< stop()
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  /// Once.
  void start();
  /// Ends: nothing more is taken, queued requests are cancelled, running ones are asked to stop and
  /// answered, the answers delivered. Blocks until then. From the owner's thread.
  void stop();
  /// Has the cells read again and prepared anew. What is wrong with them goes to the log, and the
  /// daemon goes on with the old ones. From the owner's thread, which it holds up while they are
  /// read.
  void reload(const Deadline& deadline);

  Verdict onRequest(const PlanRequest& request, bool kept) override;
  Verdict onInvalidRequest(const RequestId& id, const std::string& client_id,
                           const std::vector<Fault>& faults) override;
  void onCancel(const RequestId& id, CancelCause cause) override;
  void onClaim(const Claim& claim) override;
  void onClaimEnded(const Claim& claim) override;

 private:
  using Clock = Deadline::Clock;
  class Stream;
  using StreamPtr = std::shared_ptr<Stream>;
  using CellsPtr = std::shared_ptr<const ServedCells>;

  /// Whose a request is. @param info  what is ours of its cell, its epoch included.
  Leadership::Whose whose(const ServedCells& served, const PlanRequest& request, bool kept,
                          CellInfo& info) const;
  enum class Asked { kFirst, kAgain, kMeanwhile };
  /// Takes an id that is new. One that was answered, or is being answered to another client, is
  /// rejected; the same client has what it asks for on its way.
  Asked asked(const PlanRequest& request);

  struct Admission {
    bool ours = true;     ///< false: we have ceased to lead the cell
    std::string why_not;  ///< it cannot be taken now
    std::uint32_t ahead = 0;
  };

  /// Enters a request, where it can.
  Admission admit(const StreamPtr& stream);
  void reject(const StreamPtr& stream, RejectionReason reason, std::vector<Fault> faults);
  void finish(const StreamPtr& stream, Outcome outcome);
  static void send(Stream& stream, Outcome outcome);
  std::optional<Outcome> answer(Stream& stream);
  bool othersWait() const;
  bool isQuiet() const;
  /// Next for the preparing thread: nullptr and `stop` false: a cell.
  StreamPtr nextUnprepared(bool& stop);
  void prepareRequest(const StreamPtr& stream);
  void prepareCell();
  /// Takes waiting requests out.
  template <typename Condition>
  std::vector<StreamPtr> extract(Condition condition) HANDOVER_REQUIRES(mutex_);
  void expireQueued();
  /// Requests that wait for a worker or for what they lack, what is being made included.
  std::uint32_t waiting() const HANDOVER_REQUIRES(mutex_);
  void publishStatus();
  Leadership::Calls leadershipCalls();
  /// Gives up the answers that have begun in cells that another daemon leads now.
  void abandon(const std::vector<std::string>& cells);
  /// Sends outcomes that waited until it was known whether we lead.
  void resume();

  void prepareLoop() noexcept;
  void workerLoop(int index) noexcept;
  void statusLoop() noexcept;

  PlanService& service_;
  Endpoint& endpoint_;
  const RuntimeSettings settings_;
  const Deadline preparing_;  ///< cancelled at stop

  mutable Mutex mutex_;
  Condition work_;    // queue_, stopping_ changed
  Condition lacks_;   // unprepared_, stopping_ changed
  Condition report_;  // something to report, a new deadline, or stopping
  FairQueue<StreamPtr> queue_ HANDOVER_GUARDED_BY(mutex_);
  FairQueue<StreamPtr> unprepared_ HANDOVER_GUARDED_BY(mutex_);  // something has to be made first
  ClientAccounts accounts_ HANDOVER_GUARDED_BY(mutex_);
  std::uint32_t being_prepared_ HANDOVER_GUARDED_BY(mutex_) = 0;  // taken out of unprepared_
  std::map<RequestId, StreamPtr> open_ HANDOVER_GUARDED_BY(mutex_);
  std::set<RequestId> known_ HANDOVER_GUARDED_BY(mutex_);       // being answered and remembered
  std::deque<RequestId> answered_ HANDOVER_GUARDED_BY(mutex_);  // remembered, oldest first
  OutcomeCounters counters_ HANDOVER_GUARDED_BY(mutex_);
  std::uint32_t running_ HANDOVER_GUARDED_BY(mutex_) = 0;
  bool ready_ HANDOVER_GUARDED_BY(mutex_) = false;
  bool was_ready_ HANDOVER_GUARDED_BY(mutex_) = false;  // with the cells of the start
  bool stopping_ HANDOVER_GUARDED_BY(mutex_) = false;
  bool changed_ HANDOVER_GUARDED_BY(mutex_) = true;
  std::string prepare_failure_ HANDOVER_GUARDED_BY(mutex_);
  RecentTimes answer_times_ HANDOVER_GUARDED_BY(mutex_);

  /// Outcomes of cells of which it is not certain whether we still lead them.
  std::vector<std::pair<StreamPtr, Outcome>> suspended_ HANDOVER_GUARDED_BY(mutex_);

  const Clock::time_point began_at_ = Clock::now();
  Leadership leadership_;  ///< asked under mutex_, never the other way round
  std::vector<std::jthread> threads_;
};

}  // namespace handover
