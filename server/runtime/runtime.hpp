// SPDX-License-Identifier: Apache-2.0
// Requests become answers: a bounded queue with fair turns for clients, workers, cancel, deadline,
// and exactly one outcome for each.
#pragma once

#include "runtime/client_accounts.hpp"
#include "runtime/election.hpp"
#include "runtime/endpoint.hpp"
#include "runtime/fair_queue.hpp"
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

/// What daemons do that serve the same cell.
enum class CellSharing {
  kStandby,  ///< one of them leads and answers, the others wait to follow it
  kShared,   ///< each answers every request
};

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

  enum class CellRoute { kOurs, kOthers, kNobodys };
  /// With what is ours of the cell, its epoch included.
  CellRoute route(const ServedCells& served, const PlanRequest& request, bool kept,
                  CellInfo& info) const;
  /// Of the daemons that are there, we reject what is nobody's.
  bool weReject(const std::vector<DaemonStatus>& others) const;
  /// Whether we lead a cell for certain, with that epoch; 0: we share it.
  bool leads(const std::string& cell, std::uint64_t epoch) const HANDOVER_REQUIRES(mutex_);
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
  /// Leads, follows and gives up cells. True when that changed what is ours.
  bool takeTurn();

  struct Changes {
    Election::Turn turn;
    std::vector<std::string> given_up;  ///< cells that we do not serve any more
    std::vector<StreamPtr> abandoned;   ///< answers of cells that another daemon leads now
  };

  Changes decide(Clock::time_point now);
  /// Tells the other daemons and the log. False: a claim could not be written.
  bool announce(const Changes& changes);
  /// @param others  outlive what is returned
  static Election::Peers peersOf(const std::vector<DaemonStatus>& others);
  /// Gives up the answers that have begun in cells that another daemon leads now.
  std::vector<StreamPtr> abandon(const std::vector<std::string>& cells) HANDOVER_REQUIRES(mutex_);
  void noteServedByOthers(const std::vector<DaemonStatus>& others, Clock::time_point now)
      HANDOVER_REQUIRES(mutex_);
  /// The cells that are ours from now on, and not before; those that are not any more.
  std::vector<std::string> standForServed(Clock::time_point now) HANDOVER_REQUIRES(mutex_);
  /// Sends outcomes that waited until it was known whether we lead.
  void resume();

  void prepareLoop() noexcept;
  void workerLoop(int index) noexcept;
  void statusLoop() noexcept;
  void leadLoop() noexcept;

  PlanService& service_;
  Endpoint& endpoint_;
  const RuntimeSettings settings_;
  const Deadline preparing_;  ///< cancelled at stop

  mutable Mutex mutex_;
  Condition work_;    // queue_, stopping_ changed
  Condition lacks_;   // unprepared_, stopping_ changed
  Condition report_;  // something to report, a new deadline, or stopping
  Condition claims_;  // a claim ended, or all is answered
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

  const Clock::time_point began_at_ = Clock::now();
  Election election_ HANDOVER_GUARDED_BY(mutex_);
  std::vector<std::string> stands_for_ HANDOVER_GUARDED_BY(mutex_);
  /// Nobody else can lead the cells that we lead before then.
  Clock::time_point leads_until_ HANDOVER_GUARDED_BY(mutex_) = Clock::time_point::min();
  /// Outcomes of cells of which it is not known whether we still lead them.
  std::vector<std::pair<StreamPtr, Outcome>> suspended_ HANDOVER_GUARDED_BY(mutex_);
  std::map<std::string, Clock::time_point> served_by_others_ HANDOVER_GUARDED_BY(mutex_);
  bool claim_ended_ HANDOVER_GUARDED_BY(mutex_) = false;
  bool all_answered_ HANDOVER_GUARDED_BY(mutex_) = false;

  std::vector<std::jthread> threads_;
  std::jthread leading_;  ///< outlives the others: nobody follows us before all is answered
};

}  // namespace handover
