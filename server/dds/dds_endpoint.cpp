// SPDX-License-Identifier: Apache-2.0
#include "dds/dds_endpoint.hpp"

#include "dds/client_stream.hpp"
#include "dds/prober.hpp"
#include "dds/sender_pool.hpp"
#include "dds/status_writer.hpp"
#include "wire/codec.hpp"
#include "wire/entities.hpp"
#include "wire/known_daemons.hpp"

#include <handover/common/log.hpp>
#include <handover/common/mutex.hpp>

#include <algorithm>
#include <map>
#include <set>

namespace handover {
namespace {

using Clock = ClientStream::Clock;

/// Writing 40 events takes 2 ms; two threads leave one while the other makes or deletes a writer.
constexpr int kSenders = 2;
/// Of a datagram to the library and our callbacks, which decode and hand on: milliseconds.
constexpr std::chrono::seconds kLongestDelivery{3};

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
                     .name = "handoverd",
                     .on_writer = [this](const wire::RemoteWriter& writer) { onWriter(writer); }}) {
  }

  const DdsEndpointSettings settings;

  mutable Mutex mutex;
  std::map<std::string, StreamPtr> clients HANDOVER_GUARDED_BY(mutex);
  std::map<RequestId, Origin> open HANDOVER_GUARDED_BY(mutex);
  wire::KnownDaemons daemons HANDOVER_GUARDED_BY(mutex);
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
    std::size_t kept = 0, spent = 0, bytes = 0;
    for (const auto& [used, client_id] : idle) {
      const ClientStream& stream = *clients[client_id];
      ++kept;
      spent += stream.spent() ? 1 : 0;
      bytes += stream.bytes();
      const bool too_many = kept > settings.most_unconfirmed || bytes > settings.most_bytes ||
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
    bool entered = false, ours = false;
    {
      const MutexLock lock(mutex);
      entered = open.emplace(id, Origin{client_id, sample.writer}).second;
    }
    deliver([&](RequestHandler& to) {
      const auto decoded = wire::decode(*sample.message);
      const auto* request = std::get_if<PlanRequest>(&decoded);
      ours = request != nullptr
                 ? to.onRequest(*request)
                 : to.onInvalidRequest(id, client_id, std::get<std::vector<Fault>>(decoded));
    });
    if (!entered || ours) return;
    const MutexLock lock(mutex);
    open.erase(id);
  }

  /// The client disposed its request: it takes it back, or has the outcome.
  void onRequestEnd(const RequestId& id, const wire::Sample<msg::HandoverRequest>& sample) {
    bool own = false;
    {
      const MutexLock lock(mutex);
      const auto found = open.find(id);
      if (found == open.end()) {
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
    if (match.gained) return;
    std::vector<RequestId> ids;
    {
      const MutexLock lock(mutex);
      for (const auto& [id, origin] : open) {
        if (origin.writer == match.peer) ids.push_back(id);
      }
    }
    for (const RequestId& id : ids) cancel(id, CancelCause::kClientLost);
  }

  void onCancel(const wire::Sample<msg::HandoverCancel>& sample) {
    if (sample.message == nullptr) return;
    const auto id = wire::decode(*sample.message);
    if (const auto* found = std::get_if<RequestId>(&id)) cancel(*found, CancelCause::kAsked);
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
    daemons.take(sample);
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
  if (std::holds_alternative<Outcome>(event.payload)) impl_->open.erase(event.request_id);
}

void DdsEndpoint::publishStatus(const DaemonStatus& status) {
  DaemonStatus counted = status;
  {
    const MutexLock lock(impl_->mutex);
    impl_->own_id = status.id;
    counted.clients = static_cast<std::uint32_t>(impl_->clients.size());
    counted.refused = impl_->refused;
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
