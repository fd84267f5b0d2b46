// SPDX-License-Identifier: Apache-2.0
#include "dds/dds_endpoint.hpp"

#include "dds/claim_writers.hpp"
#include "dds/client_stream.hpp"
#include "dds/kept_requests.hpp"
#include "dds/prober.hpp"
#include "dds/sender_pool.hpp"
#include "dds/status_writer.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"
#include "wire/known_daemons.hpp"

#include <handover/common/log.hpp>
#include <handover/common/mutex.hpp>

#include <algorithm>
#include <deque>
#include <map>
#include <set>

namespace handover {
namespace {

using Clock = ClientStream::Clock;

/// Writing 40 events takes 2 ms; two threads leave one while the other makes or deletes a writer.
constexpr int kSenders = 2;
/// Of a datagram to the library and our callbacks, which decode and hand on: milliseconds.
constexpr std::chrono::seconds kLongestDelivery{3};

/// A client's request writer that is lost for this long is gone. One that a daemon lost in its
/// sleep is back with the client's next announcements, 0.2 to 3 s later.
constexpr std::chrono::seconds kReturnTime{10};

/// A client id that can stand as a partition: answers to one that breaks our pattern still find it,
/// but partitions with wildcards would reach everybody.
bool answerable(const std::string& client_id) {
  return client_id.size() <= 256 && client_id.find_first_of("*?[]\\") == std::string::npos &&
         client_id.find('\0') == std::string::npos;
}

}  // namespace

struct DdsEndpoint::Impl {
  using StreamPtr = std::shared_ptr<ClientStream>;

  /// Who asked, until the outcome is on its way.
  struct Origin {
    std::string client_id;
    wire::Guid writer{};
  };

  explicit Impl(const DdsEndpointSettings& given)
      : settings(given),
        participant({.domain = given.domain,
                     .name = wire::kDaemonParticipant,
                     .on_writer = [this](const wire::RemoteWriter& writer) { onWriter(writer); }}) {
  }

  const DdsEndpointSettings settings;

  mutable Mutex mutex;
  std::map<std::string, StreamPtr> clients HANDOVER_GUARDED_BY(mutex);
  std::map<RequestId, Origin> open HANDOVER_GUARDED_BY(mutex);
  KeptRequests kept HANDOVER_GUARDED_BY(mutex);
  /// That have their outcome and were not disposed, oldest first, with their writers.
  std::deque<std::pair<RequestId, wire::Guid>> answered HANDOVER_GUARDED_BY(mutex);
  wire::KnownDaemons daemons HANDOVER_GUARDED_BY(mutex);
  std::map<wire::Guid, Claim> claimants HANDOVER_GUARDED_BY(mutex);  // other daemons' writers
  DaemonId own_id HANDOVER_GUARDED_BY(mutex){};
  bool receiving HANDOVER_GUARDED_BY(mutex) = false;
  /// Requests that could not be answered.
  std::uint64_t refused HANDOVER_GUARDED_BY(mutex) = 0;

  Mutex delivering;  // held while the handler runs
  RequestHandler* handler HANDOVER_GUARDED_BY(delivering) = nullptr;

  SenderPool senders{kSenders};

  // Last: their callbacks use all above.
  wire::Participant participant;
  std::optional<StatusWriter> status_writer;
  std::optional<wire::Reader<msg::DaemonStatus>> status_reader;
  std::optional<wire::Reader<msg::HandoverRequest>> request_reader;
  std::optional<wire::Reader<msg::HandoverCancel>> cancel_reader;
  std::optional<wire::Reader<msg::Leader>> leader_reader;
  ClaimWriters claims{participant};
  std::optional<wire::Writer<msg::Probe>> probe_writer;
  std::optional<wire::Reader<msg::Probe>> probe_reader;
  std::optional<Prober> prober;

  template <typename Call>
  void deliver(Call call) {
    const MutexLock lock(delivering);
    if (handler != nullptr) call(*handler);
  }

  void cancel(const RequestId& id, CancelCause cause) {
    deliver([&](RequestHandler& to) { to.onCancel(id, cause); });
  }

  // ---- streams ----

  /// The client's stream, made if need be.
  StreamPtr stream(const std::string& client_id) HANDOVER_REQUIRES(mutex) {
    StreamPtr& found = clients[client_id];
    if (found == nullptr) {
      found = std::make_shared<ClientStream>(participant, client_id, settings.retention);
      senders.post([this] { prune(); });
    }
    return found;
  }

  /// On a sender's thread: a turn of a stream that has something to send.
  void send(const StreamPtr& to) {
    const ClientStream::Sent sent = to->send();
    if (sent.more) senders.post([this, to] { send(to); });
    for (const RequestId& id : sent.broken) cancel(id, CancelCause::kClientLost);
  }

  /// Gives up streams without open requests: those unused for the retention time and, of the
  /// others, all but the last used ones. Not on Fast DDS's threads.
  void prune() {
    std::vector<StreamPtr> over;  // end without the lock
    const MutexLock lock(mutex);
    for (const std::string& client_id : surplus()) over.push_back(extract(client_id));
  }

  StreamPtr extract(const std::string& client_id) HANDOVER_REQUIRES(mutex) {
    const auto found = clients.find(client_id);
    StreamPtr stream = std::move(found->second);
    clients.erase(found);
    return stream;
  }

  std::vector<std::string> surplus() HANDOVER_REQUIRES(mutex) {
    std::set<std::string> busy;
    for (const auto& [id, origin] : open) busy.insert(origin.client_id);
    std::multimap<Clock::time_point, std::string, std::greater<>> idle;  // last used first
    for (const auto& [client_id, stream] : clients) {
      if (!busy.contains(client_id) && stream->idle()) {
        idle.emplace(stream->lastUsed(), client_id);
      }
    }
    std::vector<std::string> surplus;
    std::size_t counted = 0, spent = 0, bytes = 0;
    for (const auto& [used, client_id] : idle) {
      const ClientStream& stream = *clients[client_id];
      ++counted;
      spent += stream.spent() ? 1 : 0;
      bytes += stream.bytes();
      const bool too_many = counted > settings.most_unconfirmed || bytes > settings.most_bytes ||
                            (stream.spent() && spent > settings.most_idle);
      if (too_many || used < Clock::now() - settings.retention) surplus.push_back(client_id);
    }
    return surplus;
  }

  // ---- Fast DDS's threads ----

  /// A client's request writer carries its id: an events writer is there before the first request.
  void onWriter(const wire::RemoteWriter& writer) {
    if (writer.topic != wire::kRequestTopic || !validClientId(writer.user_data)) return;
    const MutexLock lock(mutex);
    if (!receiving) return;
    senders.post([made = stream(writer.user_data)] { made->prepare(); });
  }

  void onRequest(const wire::Sample<msg::HandoverRequest>& sample) {
    const RequestId id{sample.key};
    if (sample.message == nullptr) return onRequestEnd(id, sample);
    const std::string& client_id = sample.message->client_id();
    if (!answerable(client_id)) {
      logger("dds")->warn("request {}: its client id cannot be answered", id.hex());
      const MutexLock lock(mutex);
      ++refused;
      return;
    }
    KeptRequests::Kept asked{client_id, sample.writer, wire::decode(*sample.message)};
    asked.bytes = msg::HandoverRequest::getCdrSerializedSize(*sample.message);
    {
      const MutexLock lock(mutex);
      kept.forget(id);  // before it is asked for: what is taken may be handed back at once
    }
    if (ask(id, asked, false) != Verdict::kPerhaps) return;
    const MutexLock lock(mutex);
    kept.keep(id, std::move(asked));
  }

  /// The handler's word on a request.
  Verdict ask(const RequestId& id, const KeptRequests::Kept& asked, bool again) {
    bool entered = false;
    {
      const MutexLock lock(mutex);
      entered = open.emplace(id, Origin{asked.client_id, asked.writer}).second;
    }
    Verdict verdict = Verdict::kPerhaps;
    deliver([&](RequestHandler& to) {
      const auto* request = std::get_if<PlanRequest>(&asked.request);
      verdict = request != nullptr
                    ? to.onRequest(*request, again)
                    : to.onInvalidRequest(id, asked.client_id,
                                          std::get<std::vector<Fault>>(asked.request));
    });
    const MutexLock lock(mutex);
    if (entered && verdict != Verdict::kMine) open.erase(id);
    return verdict;
  }

  /// One that was kept, if it still is. On any thread but Fast DDS's.
  void offer(const RequestId& id) {
    std::optional<KeptRequests::Kept> asked;
    {
      const MutexLock lock(mutex);
      if (const auto* found = kept.find(id)) asked = *found;
    }
    if (!asked) return;
    const Verdict verdict = ask(id, *asked, true);
    if (verdict == Verdict::kPerhaps) return;
    {
      const MutexLock lock(mutex);
      asked = kept.take(id);
    }
    if (asked && asked->cancelled) cancel(id, *asked->cancelled);
  }

  void noteAnswered(const RequestId& id, const wire::Guid& writer) HANDOVER_REQUIRES(mutex) {
    std::erase_if(answered, [&](const auto& each) { return each.first == id; });
    answered.emplace_back(id, writer);
    if (answered.size() > kMostAnswered) answered.pop_front();
  }

  /// The client disposed its request: it takes it back, or has the outcome.
  void onRequestEnd(const RequestId& id, const wire::Sample<msg::HandoverRequest>& sample) {
    bool own = false;
    {
      const MutexLock lock(mutex);
      const auto found = open.find(id);
      if (found == open.end()) {
        const auto* waits = kept.find(id);
        if (waits != nullptr && waits->writer == sample.writer) kept.forget(id);
        std::erase_if(answered, [&](const auto& each) { return each.first == id; });
        for (const auto& [client_id, stream] : clients) stream->confirm(id);
        return;
      }
      // From its own writer only: a vendor that sends no key hash with a dispose makes us read
      // another key.
      own = found->second.writer == sample.writer;
    }
    if (own) cancel(id, sample.writers_lost ? CancelCause::kClientLost : CancelCause::kDisposed);
  }

  void onRequestMatch(const wire::Match& match) {
    std::vector<RequestId> ids;
    {
      const MutexLock lock(mutex);
      if (match.gained) return kept.regainWriter(match.peer);
      kept.loseWriter(match.peer, Clock::now());
      for (const auto& [id, origin] : open) {
        if (origin.writer == match.peer) ids.push_back(id);
      }
      std::erase_if(answered, [&](const auto& each) { return each.second == match.peer; });
    }
    for (const RequestId& id : ids) cancel(id, CancelCause::kClientLost);
  }

  void onCancel(const wire::Sample<msg::HandoverCancel>& sample) {
    if (sample.message == nullptr) return;
    const auto id = wire::decode(*sample.message);
    const auto* found = std::get_if<RequestId>(&id);
    if (found == nullptr) return;
    {
      const MutexLock lock(mutex);
      if (auto* waits = kept.find(*found)) waits->cancelled = CancelCause::kAsked;
    }
    cancel(*found, CancelCause::kAsked);
  }

  void onLeader(const wire::Sample<msg::Leader>& sample) {
    if (wire::sameParticipant(sample.writer, participant.guid())) return;
    if (sample.message == nullptr) return onLeaderEnd(sample);
    const auto decoded = wire::decode(*sample.message);
    const auto* claim = std::get_if<Claim>(&decoded);
    if (claim == nullptr) return;
    {
      const MutexLock lock(mutex);
      claimants[sample.writer] = *claim;
    }
    deliver([&](RequestHandler& to) { to.onClaim(*claim); });
  }

  /// A claim was given up. A writer that is lost says nothing: we may have slept, and it leads.
  void onLeaderEnd(const wire::Sample<msg::Leader>& sample) {
    if (sample.writers_lost) return;
    std::optional<Claim> ended;
    {
      const MutexLock lock(mutex);
      const auto found = claimants.find(sample.writer);
      if (found == claimants.end()) return;
      ended = found->second;
    }
    deliver([&](RequestHandler& to) { to.onClaimEnded(*ended); });
  }

  void onLeaderMatch(const wire::Match& match) {
    if (match.gained) return;
    const MutexLock lock(mutex);
    claimants.erase(match.peer);
  }

  /// Answered through everything that a request's event goes through but the runtime's work.
  void onProbe(const wire::Sample<msg::Probe>& sample) {
    if (sample.message == nullptr || sample.message->answer() ||
        sample.message->participant() != participant.guid()) {
      return;
    }
    msg::Probe answer = *sample.message;
    answer.answer(true);
    deliver([](RequestHandler&) {});  // hangs where the handler does
    senders.post([this, answer] { (void)probe_writer->write(answer); });
  }

  void onStatus(const wire::Sample<msg::DaemonStatus>& sample) {
    const MutexLock lock(mutex);
    const DaemonStatus* status = daemons.take(sample);
    if (status == nullptr || status->id == own_id) return;
    for (const RequestId& id : status->answered) kept.forget(id);
  }

  void onStatusMatch(const wire::Match& match) {
    if (match.gained) return;
    const MutexLock lock(mutex);
    daemons.lose(match.peer);
  }
};

DdsEndpoint::DdsEndpoint(const DdsEndpointSettings& settings)
    : impl_(std::make_unique<Impl>(settings)) {
  Impl& impl = *impl_;
  impl.status_writer.emplace(impl.participant, settings.statuses);
  impl.status_reader.emplace(
      impl.participant,
      wire::EntityOptions{.on_match = [&impl](const auto& match) { impl.onStatusMatch(match); }},
      [&impl](const auto& sample) { impl.onStatus(sample); });
  impl.probe_writer.emplace(impl.participant, wire::EntityOptions{});
  impl.probe_reader.emplace(impl.participant, wire::EntityOptions{},
                            [&impl](const auto& sample) { impl.onProbe(sample); });
}

DdsEndpoint::~DdsEndpoint() {
  DdsEndpoint::stopReceiving();
  impl_->probe_reader.reset();
  impl_->request_reader.reset();
  impl_->cancel_reader.reset();
  impl_->leader_reader.reset();
  impl_->status_reader.reset();
  impl_->senders.stop();
  std::map<std::string, Impl::StreamPtr> clients;  // end without the lock
  const MutexLock lock(impl_->mutex);
  clients.swap(impl_->clients);
}

void DdsEndpoint::open(RequestHandler& handler) {
  Impl& impl = *impl_;
  {
    const MutexLock lock(impl.delivering);
    impl.handler = &handler;
  }
  {
    const MutexLock lock(impl.mutex);
    impl.receiving = true;
  }
  impl.leader_reader.emplace(
      impl.participant,
      wire::EntityOptions{.on_match = [&impl](const auto& match) { impl.onLeaderMatch(match); }},
      [&impl](const auto& sample) { impl.onLeader(sample); });
  impl.cancel_reader.emplace(impl.participant, wire::EntityOptions{},
                             [&impl](const auto& sample) { impl.onCancel(sample); });
  impl.request_reader.emplace(
      impl.participant,
      wire::EntityOptions{.on_match = [&impl](const auto& match) { impl.onRequestMatch(match); }},
      [&impl](const auto& sample) { impl.onRequest(sample); });
}

void DdsEndpoint::stopReceiving() {
  {
    const MutexLock lock(impl_->delivering);
    impl_->handler = nullptr;
  }
  {
    const MutexLock lock(impl_->mutex);
    impl_->receiving = false;
  }
}

void DdsEndpoint::publish(const std::string& client_id, const PlanEvent& event) {
  PlanEvent copy = event;
  const MutexLock lock(impl_->mutex);
  const Impl::StreamPtr to = impl_->stream(client_id);
  if (to->push(std::move(copy))) impl_->senders.post([impl = impl_.get(), to] { impl->send(to); });
  if (!std::holds_alternative<Outcome>(event.payload)) return;
  const auto found = impl_->open.find(event.request_id);
  if (found == impl_->open.end()) return;
  impl_->noteAnswered(event.request_id, found->second.writer);
  impl_->open.erase(found);
}

void DdsEndpoint::publishStatus(const DaemonStatus& status) {
  DaemonStatus counted = status;
  {
    const MutexLock lock(impl_->mutex);
    impl_->own_id = status.id;
    impl_->kept.forgetLost(Clock::now() - kReturnTime);
    counted.clients = static_cast<std::uint32_t>(impl_->clients.size());
    counted.refused = impl_->refused;
    counted.kept_requests = static_cast<std::uint32_t>(impl_->kept.size());
    for (const auto& [id, writer] : impl_->answered) counted.answered.push_back(id);
  }
  counted.dropped_packets = impl_->participant.droppedPackets();
  if (impl_->status_writer->write(wire::encode(counted)) != wire::WriteResult::kOk) {
    logger("dds")->warn("the status could not be written");
  }
  impl_->prune();
}

std::vector<DaemonStatus> DdsEndpoint::others() const {
  const MutexLock lock(impl_->mutex);
  std::vector<DaemonStatus> others = impl_->daemons.all();
  const DaemonId own = impl_->own_id;
  std::erase_if(others, [&](const DaemonStatus& daemon) { return daemon.id == own; });
  return others;
}

bool DdsEndpoint::claim(const Claim& claim) { return impl_->claims.write(claim); }

void DdsEndpoint::giveUp(const CellKey& cell) { impl_->claims.end(cell); }

void DdsEndpoint::offerKept() {
  std::vector<RequestId> ids;
  {
    const MutexLock lock(impl_->mutex);
    ids = impl_->kept.ids();
  }
  for (const RequestId& id : ids) impl_->offer(id);
}

void DdsEndpoint::handBack(const PlanRequest& request) {
  Impl::StreamPtr stream;
  {
    const MutexLock lock(impl_->mutex);
    const auto found = impl_->open.find(request.id);
    if (found != impl_->open.end()) {
      const auto bytes = msg::HandoverRequest::getCdrSerializedSize(wire::encode(request));
      impl_->kept.keep(request.id, {request.client_id, found->second.writer, request, bytes});
      impl_->open.erase(found);
    }
    const auto client = impl_->clients.find(request.client_id);
    if (client != impl_->clients.end()) stream = client->second;
  }
  if (stream != nullptr) stream->giveUp(request.id);
}

bool DdsEndpoint::reachable(std::chrono::milliseconds most) {
  Impl& impl = *impl_;
  // The probe has been met before: only others, who come later, find nobody then.
  const auto until = Clock::now() + most;
  while (impl.participant.atOneDatagram() > kLongestDelivery) {
    if (Clock::now() >= until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));  // it may have been stopped
  }
  if (!impl.prober) impl.prober.emplace(impl.settings.domain, impl.participant.guid());
  return impl.prober->probe(most);
}

void DdsEndpoint::flush(std::chrono::milliseconds most) {
  using namespace std::chrono_literals;
  const auto until = Clock::now() + most;
  std::vector<Impl::StreamPtr> streams;
  {
    const MutexLock lock(impl_->mutex);
    for (const auto& [client_id, stream] : impl_->clients) streams.push_back(stream);
  }
  while (Clock::now() < until) {
    std::erase_if(streams, [](const auto& stream) { return stream->delivered(); });
    if (streams.empty()) return;
    std::this_thread::sleep_for(2ms);
  }
}

}  // namespace handover
