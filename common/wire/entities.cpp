// SPDX-License-Identifier: Apache-2.0
#include "wire/entities.hpp"

#include "wire/message_type.hpp"
#include "wire/packet_guard.hpp"

#include <handover/common/domain.hpp>
#include <handover/common/log.hpp>
#include <handover/common/mutex.hpp>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <handoverPubSubTypes.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <mutex>

namespace handover::wire {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;
using Seconds = std::chrono::duration<double>;

struct TopicRow {
  TopicId id;
  const char* name;
};

constexpr TopicRow kTopics[] = {
    {TopicId::kRequest, kRequestTopic},       {TopicId::kCancel, "handover/v1/cancel"},
    {TopicId::kEvent, "handover/v1/event"},   {TopicId::kStatus, "handover/v1/status"},
    {TopicId::kLeader, "handover/v1/leader"}, {TopicId::kProbe, "handover/v1/probe"}};
constexpr std::size_t kTopicCount = std::size(kTopics);

constexpr int kEventsPerAnswer = 4096;
/// Readers recycle an instance only when it was disposed: room for many that never were.
constexpr int kReaderInstances = 1 << 18;
/// Open requests or cancels of a client, daemons of one process.
constexpr int kInstancesPerWriter = 4096;
/// What readers set aside for a sample before they know its size.
constexpr std::uint32_t kPayloadSize = 4096;

dds::TypeSupport makeType(TopicId id) {
  dds::TopicDataType* type = nullptr;
  switch (id) {
    case TopicId::kRequest:
      type = new MessageType<msg::HandoverRequestPubSubType>;
      break;
    case TopicId::kCancel:
      type = new MessageType<msg::HandoverCancelPubSubType>;
      break;
    case TopicId::kEvent:
      type = new MessageType<msg::PlanEventPubSubType>;
      break;
    case TopicId::kStatus:
      type = new MessageType<msg::DaemonStatusPubSubType>;
      break;
    case TopicId::kLeader:
      type = new MessageType<msg::LeaderPubSubType>;
      break;
    case TopicId::kProbe:
      type = new MessageType<msg::ProbePubSubType>;
      break;
  }
  dds::TypeSupport support(type);
  // Type information keeps other vendors from matching, type objects crash peers of this version.
  support->auto_fill_type_object(false);
  support->auto_fill_type_information(false);
  // Readers would preallocate the generated maximum size, up to 20 MB, for each sample.
  support->m_typeSize = kPayloadSize;
  return support;
}

Guid toGuid(const rtps::GUID_t& guid) {
  Guid out;
  std::memcpy(out.data(), guid.guidPrefix.value, 12);
  std::memcpy(out.data() + 12, guid.entityId.value, 4);
  return out;
}

Guid toGuid(const rtps::InstanceHandle_t& handle) { return toGuid(rtps::iHandle2GUID(handle)); }

dds::DomainParticipantQos participantQos(const std::string& name,
                                         std::shared_ptr<GuardWatch> watch) {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  qos.name(name);
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  udp->maxInitialPeersRange = 110;  // 4 by default: the fifth participant would find nobody
  udp->sendBufferSize = 4 << 20;
  udp->receiveBufferSize = 4 << 20;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(guarded(udp, std::move(watch)));
  rtps::Locator_t loopback;
  eprosima::fastrtps::rtps::IPLocator::setIPv4(loopback, "127.0.0.1");
  auto& builtin = qos.wire_protocol().builtin;
  builtin.initialPeersList.push_back(loopback);
  builtin.metatrafficUnicastLocatorList.push_back(loopback);
  builtin.discovery_config.leaseDuration = {3, 0};
  // A lost first exchange waits for the next announcement: 3 s by default.
  builtin.discovery_config.leaseDuration_announcementperiod = {0, 200'000'000};
  builtin.discovery_config.initial_announcements = {10, {0, 20'000'000}};
  return qos;
}

/// Samples of all instances together are not limited: the middleware adds up the limits of all
/// readers and writers of a topic, in 32 bits.
void limits(dds::ResourceLimitsQosPolicy& limits, int instances, int per_instance) {
  limits.max_instances = instances;
  limits.max_samples_per_instance = per_instance;
  limits.max_samples = 0;
  limits.allocated_samples = 16;
}

bool durable(TopicId topic) { return topic != TopicId::kCancel && topic != TopicId::kProbe; }

/// What writers and readers of a topic have in common. Events are all kept, of the others the last
/// one of each instance.
template <typename Qos>
void configureTopic(Qos& qos, TopicId topic, int instances) {
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind =
      durable(topic) ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  if (topic == TopicId::kEvent) {
    qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
    limits(qos.resource_limits(), instances, kEventsPerAnswer);
  } else {
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 1;
    limits(qos.resource_limits(), instances, 1);
  }
  qos.data_sharing().off();
  if (topic != TopicId::kLeader) return;
  qos.ownership().kind = dds::EXCLUSIVE_OWNERSHIP_QOS;
  qos.liveliness().kind = dds::MANUAL_BY_TOPIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = {0,
                                     1'000'000 * static_cast<std::uint32_t>(kLeaderLease.count())};
}

/// The partition of a publisher or subscriber; its entities start when they are told to.
template <typename Qos>
void configureGroup(Qos& qos, const EntityOptions& options) {
  if (!options.partition.empty()) qos.partition().push_back(options.partition.c_str());
  qos.entity_factory().autoenable_created_entities = false;
}

dds::DataWriterQos writerQos(TopicId topic, const EntityOptions& options) {
  dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
  configureTopic(qos, topic, topic == TopicId::kEvent ? kAnswersPerWriter : kInstancesPerWriter);
  // Reused payloads never shrink: all that a process ever held at once would grow to its largest.
  qos.endpoint().history_memory_policy = rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  qos.reliability().max_blocking_time = {0, 20'000'000};
  qos.reliable_writer_qos().times.heartbeatPeriod = {0, 100'000'000};
  // A remote reader with a content filter crashes writers of this version on samples from 8 KB on.
  qos.writer_resource_limits().reader_filters_allocation.initial = 0;
  qos.writer_resource_limits().reader_filters_allocation.maximum = 0;
  qos.user_data().setValue(
      std::vector<rtps::octet>(options.user_data.begin(), options.user_data.end()));
  if (topic == TopicId::kLeader) qos.ownership_strength().value = options.strength;
  return qos;
}

dds::DataReaderQos readerQos(TopicId topic) {
  dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
  configureTopic(qos, topic, kReaderInstances);
  // A late reader asks for what it missed as soon as it has matched.
  qos.reliable_reader_qos().times.initialAcknackDelay = {0, 1'000'000};
  // Readers of the dynamic policies take no empty payload in this version, as a dispose from
  // another process is: they wait for it forever, and for all that comes after it.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

template <typename Call>
void guarded(const char* what, Call call) noexcept {
  try {
    call();
  } catch (const std::exception& error) {
    logger("dds")->error("{}: {}", what, error.what());
  } catch (...) {
    logger("dds")->error("{}: unknown exception", what);
  }
}

/// Tells an entity's owner of a peer that came or went.
template <typename MatchedStatus>
void reportMatch(const EntityOptions& options, const rtps::InstanceHandle_t& peer,
                 const MatchedStatus& status) {
  if (!options.on_match) return;
  guarded("match", [&] {
    options.on_match({toGuid(peer), status.current_count_change > 0, status.current_count});
  });
}

void expect(ReturnCode code, const char* what) {
  if (code != ReturnCode::RETCODE_OK) {
    throw DdsError(std::string(what) + " failed, DDS code " + std::to_string(code()));
  }
}

template <typename T>
T* expect(T* entity, const char* what) {
  if (entity == nullptr) throw DdsError(std::string("cannot make the ") + what);
  return entity;
}

/// Into our log; a message that repeats the last one of its category is left out.
class LogConsumer : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    if (entry.message == last_) return;
    last_ = entry.message;
    const auto level =
        entry.kind == dds::Log::Kind::Error ? spdlog::level::warn : spdlog::level::debug;
    logger("fastdds")->log(level, "{}: {}", entry.context.category ? entry.context.category : "",
                           entry.message);
  }

 private:
  std::string last_;
};

}  // namespace

void routeDdsLog(bool errors_only) {
  dds::Log::ClearConsumers();
  dds::Log::SetVerbosity(errors_only ? dds::Log::Kind::Error : dds::Log::Kind::Warning);
  dds::Log::RegisterConsumer(std::make_unique<LogConsumer>());
}

void deliverOverSockets() {
  eprosima::fastrtps::LibrarySettingsAttributes settings;
  settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
  eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
}

struct Participant::Impl : public dds::DomainParticipantListener {
  ParticipantOptions options;
  dds::DomainParticipant* participant = nullptr;
  std::array<dds::Topic*, kTopicCount> topics{};
  const std::shared_ptr<GuardWatch> watch = std::make_shared<GuardWatch>();
  mutable Mutex mutex;
  std::map<rtps::GuidPrefix_t, std::string> others HANDOVER_GUARDED_BY(mutex);  // names

  explicit Impl(ParticipantOptions given) : options(std::move(given)) {}

  ~Impl() override {
    if (participant == nullptr) return;
    participant->set_listener(nullptr);
    for (auto* topic : topics) {
      if (topic != nullptr) participant->delete_topic(topic);
    }
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }

  void open() {
    auto* factory = dds::DomainParticipantFactory::get_instance();
    dds::DomainParticipantFactoryQos factory_qos;
    factory->get_qos(factory_qos);
    factory_qos.entity_factory().autoenable_created_entities = false;
    factory->set_qos(factory_qos);
    participant = expect(factory->create_participant(static_cast<dds::DomainId_t>(options.domain),
                                                     participantQos(options.name, watch), this,
                                                     dds::StatusMask::none()),
                         "DDS participant");
    // Types first: whatever else uses a participant with unregistered types misses them.
    for (std::size_t i = 0; i < kTopicCount; ++i) {
      dds::TypeSupport type = makeType(kTopics[i].id);
      expect(type.register_type(participant), "registering a type");
      topics[i] = expect(
          participant->create_topic(kTopics[i].name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT),
          "DDS topic");
    }
    expect(participant->enable(), "enabling the participant");
  }

  dds::Topic* topic(TopicId id) const {
    for (std::size_t i = 0; i < kTopicCount; ++i) {
      if (kTopics[i].id == id) return topics[i];
    }
    throw DdsError("unknown topic");
  }

  void on_participant_discovery(dds::DomainParticipant*,
                                rtps::ParticipantDiscoveryInfo&& info) override {
    using Info = rtps::ParticipantDiscoveryInfo;
    guarded("discovery", [&] {
      const MutexLock lock(mutex);
      const auto& prefix = info.info.m_guid.guidPrefix;
      if (info.status == Info::DISCOVERED_PARTICIPANT) {
        others[prefix] = info.info.m_participantName.to_string();
      } else if (info.status != Info::CHANGED_QOS_PARTICIPANT) {
        others.erase(prefix);
      }
    });
  }

  void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    if (info.status != rtps::WriterDiscoveryInfo::DISCOVERED_WRITER || !options.on_writer) return;
    guarded("discovery", [&] {
      const auto& data = info.info.m_qos.m_userData.data_vec();
      options.on_writer({toGuid(info.info.guid()), info.info.topicName().to_string(),
                         std::string(data.begin(), data.end())});
    });
  }
};

Participant::Participant(ParticipantOptions options) {
  if (options.domain < 0 || options.domain > kMaxDomain) {
    throw DdsError("domain " + std::to_string(options.domain) + " is not in 0..232");
  }
  impl_ = std::make_shared<Impl>(std::move(options));
  impl_->open();
}

Guid Participant::guid() const { return toGuid(impl_->participant->guid()); }

int Participant::others(const std::string& name) const {
  const MutexLock lock(impl_->mutex);
  return static_cast<int>(std::count_if(impl_->others.begin(), impl_->others.end(),
                                        [&](const auto& other) { return other.second == name; }));
}

std::uint64_t Participant::droppedPackets() const { return impl_->watch->dropped; }

std::chrono::steady_clock::duration Participant::atOneDatagram() const {
  return impl_->watch->atOne();
}

struct WriterCore::Impl : public dds::DataWriterListener {
  std::shared_ptr<Participant::Impl> parent;
  EntityOptions options;
  dds::Publisher* publisher = nullptr;
  dds::DataWriter* writer = nullptr;
  std::atomic<int> peers{0};

  Impl(std::shared_ptr<Participant::Impl> owner, TopicId topic, EntityOptions given)
      : parent(std::move(owner)), options(std::move(given)) {
    try {
      open(topic);
    } catch (...) {
      close();
      throw;
    }
  }

  ~Impl() override { close(); }

  void open(TopicId topic) {
    dds::PublisherQos qos = dds::PUBLISHER_QOS_DEFAULT;
    configureGroup(qos, options);
    publisher = expect(parent->participant->create_publisher(qos), "DDS publisher");
    expect(publisher->enable(), "enabling a publisher");
    writer =
        expect(publisher->create_datawriter(parent->topic(topic), writerQos(topic, options), this),
               "DDS writer");
    expect(writer->enable(), "enabling a writer");
  }

  void close() {
    if (writer != nullptr) {
      writer->set_listener(nullptr);
      // Deleting a writer of this version frees what is in its history while a heartbeat may walk
      // it, forever then, if a reader lags behind.
      writer->clear_history(nullptr);
      publisher->delete_datawriter(writer);
    }
    if (publisher != nullptr) parent->participant->delete_publisher(publisher);
  }

  void on_publication_matched(dds::DataWriter*,
                              const dds::PublicationMatchedStatus& status) override {
    peers = status.current_count;
    reportMatch(options, status.last_subscription_handle, status);
  }
};

WriterCore::WriterCore(const Participant& participant, TopicId topic, EntityOptions options)
    : impl_(std::make_unique<Impl>(participant.impl_, topic, std::move(options))) {}

WriterCore::WriterCore(WriterCore&&) noexcept = default;
WriterCore& WriterCore::operator=(WriterCore&&) noexcept = default;
WriterCore::~WriterCore() = default;

// Fast DDS takes messages by void* and only reads them.
WriteResult WriterCore::write(const void* message) {
  const ReturnCode code =
      impl_->writer->write(const_cast<void*>(message), dds::HANDLE_NIL);  // NOLINT
  if (code == ReturnCode::RETCODE_OK) return WriteResult::kOk;
  return code == ReturnCode::RETCODE_TIMEOUT ? WriteResult::kTimeout : WriteResult::kError;
}

bool WriterCore::dispose(const void* message) {
  return impl_->writer->dispose(const_cast<void*>(message), dds::HANDLE_NIL) ==  // NOLINT
         ReturnCode::RETCODE_OK;
}

bool WriterCore::unregister(const void* message) {
  return impl_->writer->unregister_instance(const_cast<void*>(message),
                                            dds::HANDLE_NIL) ==  // NOLINT
         ReturnCode::RETCODE_OK;
}

bool WriterCore::waitForAcknowledgments(std::chrono::milliseconds most) {
  return impl_->writer->wait_for_acknowledgments({Seconds(most).count()}) == ReturnCode::RETCODE_OK;
}

int WriterCore::matched() const { return impl_->peers; }

struct ReaderCore::Impl : public dds::DataReaderListener {
  std::shared_ptr<Participant::Impl> parent;
  EntityOptions options;
  std::shared_ptr<void> scratch;
  std::function<void(const RawSample&)> on_sample;
  std::mutex taking;  // guards scratch: several receive threads may report data
  dds::Subscriber* subscriber = nullptr;
  dds::DataReader* reader = nullptr;
  std::atomic<int> peers{0};

  Impl(std::shared_ptr<Participant::Impl> owner, TopicId topic, EntityOptions given,
       std::shared_ptr<void> message, std::function<void(const RawSample&)> call)
      : parent(std::move(owner)),
        options(std::move(given)),
        scratch(std::move(message)),
        on_sample(std::move(call)) {
    try {
      open(topic);
    } catch (...) {
      close();
      throw;
    }
  }

  ~Impl() override { close(); }

  void open(TopicId topic) {
    dds::SubscriberQos qos = dds::SUBSCRIBER_QOS_DEFAULT;
    configureGroup(qos, options);
    subscriber = expect(parent->participant->create_subscriber(qos), "DDS subscriber");
    expect(subscriber->enable(), "enabling a subscriber");
    reader = expect(subscriber->create_datareader(parent->topic(topic), readerQos(topic), this),
                    "DDS reader");
    expect(reader->enable(), "enabling a reader");
  }

  void close() {
    if (reader != nullptr) {
      reader->set_listener(nullptr);
      subscriber->delete_datareader(reader);
    }
    if (subscriber != nullptr) parent->participant->delete_subscriber(subscriber);
  }

  void on_data_available(dds::DataReader* from) override {
    const std::lock_guard lock(taking);
    dds::SampleInfo info;
    while (from->take_next_sample(scratch.get(), &info) == ReturnCode::RETCODE_OK) {
      RawSample sample;
      sample.message = info.valid_data ? scratch.get() : nullptr;
      // Keys are 16 octets, which makes the key hash the key itself.
      std::memcpy(sample.key.data(), static_cast<const rtps::octet*>(info.instance_handle.value),
                  16);
      sample.writer = toGuid(info.publication_handle);
      sample.writers_lost =
          !info.valid_data && info.instance_state == dds::NOT_ALIVE_NO_WRITERS_INSTANCE_STATE;
      guarded("sample", [&] { on_sample(sample); });
    }
  }

  void on_subscription_matched(dds::DataReader*,
                               const dds::SubscriptionMatchedStatus& status) override {
    peers = status.current_count;
    reportMatch(options, status.last_publication_handle, status);
  }
};

ReaderCore::ReaderCore(const Participant& participant, TopicId topic, EntityOptions options,
                       std::shared_ptr<void> scratch,
                       std::function<void(const RawSample&)> on_sample)
    : impl_(std::make_unique<Impl>(participant.impl_, topic, std::move(options), std::move(scratch),
                                   std::move(on_sample))) {}

ReaderCore::ReaderCore(ReaderCore&&) noexcept = default;
ReaderCore& ReaderCore::operator=(ReaderCore&&) noexcept = default;
ReaderCore::~ReaderCore() = default;

int ReaderCore::matched() const { return impl_->peers; }

}  // namespace handover::wire
