// SPDX-License-Identifier: Apache-2.0
#include "dds/dds_endpoint.hpp"

#include "dds/client_stream.hpp"
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

/// A client id that can stand as a partition: answers to one that breaks our pattern still find it,
/// but partitions with wildcards would reach everybody.
bool answerable(const std::string& client_id) {
  return client_id.size() <= 256 && client_id.find_first_of("*?[]\\") == std::string::npos &&
         client_id.find('\0') == std::string::npos;
}

}  // namespace

struct DdsEndpoint::Impl {
  explicit Impl(const DdsEndpointSettings& given)
      : settings(given),
        participant({.domain = given.domain,
                     .name = "handoverd",
                     .on_writer = [this](const wire::RemoteWriter& writer) { onWriter(writer); }}) {
  }

  const DdsEndpointSettings settings;

  mutable Mutex mutex;
  std::map<std::string, std::unique_ptr<ClientStream>> clients HANDOVER_GUARDED_BY(mutex);
  std::map<std::string, std::set<RequestId>> requests_of_client HANDOVER_GUARDED_BY(mutex);
  std::map<wire::Guid, std::set<RequestId>> requests_of_writer HANDOVER_GUARDED_BY(mutex);
  wire::KnownDaemons daemons HANDOVER_GUARDED_BY(mutex);
  DaemonId own_id HANDOVER_GUARDED_BY(mutex){};
  bool receiving HANDOVER_GUARDED_BY(mutex) = false;
  /// Requests that could not be answered.
  std::uint64_t refused HANDOVER_GUARDED_BY(mutex) = 0;

  Mutex delivering;  // held while the handler runs
  RequestHandler* handler HANDOVER_GUARDED_BY(delivering) = nullptr;

  // Last: their callbacks use all above.
  wire::Participant participant;
  std::optional<wire::Writer<msg::DaemonStatus>> status_writer;
  std::optional<wire::Reader<msg::DaemonStatus>> status_reader;
  std::optional<wire::Reader<msg::HandoverRequest>> request_reader;
  std::optional<wire::Reader<msg::HandoverCancel>> cancel_reader;

  template <typename Call>
  void deliver(Call call) {
    const MutexLock lock(delivering);
    if (handler != nullptr) call(*handler);
  }

  /// The client's stream, made if need be; null when there are too many.
  ClientStream* stream(const std::string& client_id) HANDOVER_REQUIRES(mutex) {
    auto found = clients.find(client_id);
    if (found != clients.end()) return found->second.get();
    if (clients.size() >= settings.max_clients) return nullptr;
    auto made = std::make_unique<ClientStream>(
        participant, client_id, ClientStream::Settings{settings.retention, settings.max_backlog},
        [this, client_id] { cancelAll(client_id); });
    return clients.emplace(client_id, std::move(made)).first->second.get();
  }

  void cancelAll(const std::string& client_id) {
    std::set<RequestId> ids;
    {
      const MutexLock lock(mutex);
      ids.swap(requests_of_client[client_id]);
    }
    for (const RequestId& id : ids) {
      deliver([&](RequestHandler& to) { to.onCancel(id, CancelCause::kClientLost); });
    }
  }

  /// A client's request writer carries its id: its events writer is there before the first request.
  void onWriter(const wire::RemoteWriter& writer) {
    if (writer.topic != wire::kRequestTopic || !validClientId(writer.user_data)) return;
    const MutexLock lock(mutex);
    if (receiving) stream(writer.user_data);
  }

  void onRequest(const wire::Sample<msg::HandoverRequest>& sample) {
    const RequestId id{sample.key};
    if (sample.message == nullptr) {
      // From its own writer only: a vendor that sends no key hash with a dispose makes us read
      // another key.
      bool own = false;
      {
        const MutexLock lock(mutex);
        const auto found = requests_of_writer.find(sample.writer);
        own = found != requests_of_writer.end() && found->second.contains(id);
      }
      const CancelCause cause =
          sample.writers_lost ? CancelCause::kClientLost : CancelCause::kDisposed;
      if (own) deliver([&](RequestHandler& to) { to.onCancel(id, cause); });
      return;
    }
    const std::string& client_id = sample.message->client_id();
    const auto decoded = wire::decode(*sample.message);
    if (!answerable(client_id)) {
      logger("dds")->warn("request {}: its client id cannot be answered", id.hex());
      const MutexLock lock(mutex);
      ++refused;
      return;
    }
    {
      const MutexLock lock(mutex);
      if (stream(client_id) == nullptr) {
        logger("dds")->warn("request {} of {}: more than {} clients", id.hex(), client_id,
                            settings.max_clients);
        ++refused;
        return;
      }
      requests_of_client[client_id].insert(id);
      requests_of_writer[sample.writer].insert(id);
    }
    deliver([&](RequestHandler& to) {
      if (const auto* request = std::get_if<PlanRequest>(&decoded)) {
        to.onRequest(*request);
      } else {
        to.onInvalidRequest(id, client_id, std::get<std::vector<Fault>>(decoded));
      }
    });
  }

  void onRequestMatch(const wire::Match& match) {
    if (match.gained) return;
    std::set<RequestId> ids;
    {
      const MutexLock lock(mutex);
      const auto found = requests_of_writer.find(match.peer);
      if (found == requests_of_writer.end()) return;
      ids.swap(found->second);
      requests_of_writer.erase(found);
    }
    for (const RequestId& id : ids) {
      deliver([&](RequestHandler& to) { to.onCancel(id, CancelCause::kClientLost); });
    }
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

  /// Forgets a request whose outcome is on its way, and clients that are idle.
  void answered(const std::string& client_id, const RequestId& id) HANDOVER_REQUIRES(mutex) {
    const auto of_client = requests_of_client.find(client_id);
    if (of_client != requests_of_client.end()) {
      of_client->second.erase(id);
      if (of_client->second.empty()) requests_of_client.erase(of_client);
    }
    for (auto it = requests_of_writer.begin(); it != requests_of_writer.end();) {
      it->second.erase(id);
      it = it->second.empty() ? requests_of_writer.erase(it) : std::next(it);
    }
  }

  void reapClients() {
    std::vector<std::unique_ptr<ClientStream>> idle;  // joined without the lock
    const MutexLock lock(mutex);
    for (auto it = clients.begin(); it != clients.end();) {
      if (!requests_of_client.contains(it->first) && it->second->idle()) {
        idle.push_back(std::move(it->second));
        it = clients.erase(it);
      } else {
        ++it;
      }
    }
  }
};

DdsEndpoint::DdsEndpoint(const DdsEndpointSettings& settings)
    : impl_(std::make_unique<Impl>(settings)) {
  Impl& impl = *impl_;
  impl.status_writer.emplace(impl.participant, wire::EntityOptions{});
  impl.status_reader.emplace(
      impl.participant,
      wire::EntityOptions{.on_match = [&impl](const auto& match) { impl.onStatusMatch(match); }},
      [&impl](const auto& sample) { impl.onStatus(sample); });
}

DdsEndpoint::~DdsEndpoint() {
  DdsEndpoint::stopReceiving();
  impl_->status_reader.reset();
  // Streams are joined without the lock: their threads may be in a callback that takes it.
  std::map<std::string, std::unique_ptr<ClientStream>> clients;
  {
    const MutexLock lock(impl_->mutex);
    clients.swap(impl_->clients);
  }
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
                             [&impl](const wire::Sample<msg::HandoverCancel>& sample) {
                               if (sample.message == nullptr) return;
                               const auto id = wire::decode(*sample.message);
                               if (!std::holds_alternative<RequestId>(id)) return;
                               impl.deliver([&](RequestHandler& to) {
                                 to.onCancel(std::get<RequestId>(id), CancelCause::kAsked);
                               });
                             });
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
  const MutexLock lock(impl_->mutex);
  ClientStream* stream = impl_->stream(client_id);
  if (stream == nullptr) return;
  stream->publish(event);
  if (std::holds_alternative<Outcome>(event.payload)) impl_->answered(client_id, event.request_id);
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
  impl_->reapClients();
}

std::vector<DaemonStatus> DdsEndpoint::others() const {
  const MutexLock lock(impl_->mutex);
  std::vector<DaemonStatus> others = impl_->daemons.all();
  const DaemonId own = impl_->own_id;
  std::erase_if(others, [&](const DaemonStatus& daemon) { return daemon.id == own; });
  return others;
}

void DdsEndpoint::flush(std::chrono::milliseconds most) {
  const auto until = std::chrono::steady_clock::now() + most;
  std::vector<ClientStream*> streams;  // only publishStatus() and the destructor end streams
  {
    const MutexLock lock(impl_->mutex);
    for (const auto& [id, stream] : impl_->clients) streams.push_back(stream.get());
  }
  for (ClientStream* stream : streams) stream->flush(until);
}

}  // namespace handover
