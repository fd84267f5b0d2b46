// SPDX-License-Identifier: Apache-2.0
#include "ping_pong.hpp"

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <stdexcept>

namespace handover::bench {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;

using Bytes = std::array<char, 256>;

/// 256 bytes as they are, after the header that every payload has.
class BytesType : public dds::TopicDataType {
 public:
  BytesType() {
    setName("bytes256");
    m_typeSize = kHeader + sizeof(Bytes);
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const std::array<rtps::octet, kHeader> little_endian{0, 1, 0, 0};
    std::memcpy(payload->data, little_endian.data(), kHeader);
    std::memcpy(payload->data + kHeader, data, sizeof(Bytes));
    payload->length = m_typeSize;
    return true;
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    if (payload->length < m_typeSize) return false;
    std::memcpy(data, payload->data + kHeader, sizeof(Bytes));
    return true;
  }

  std::function<uint32_t()> getSerializedSizeProvider(void*) override {
    return [size = m_typeSize] { return size; };
  }

  void* createData() override { return new Bytes; }

  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }

  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  static constexpr uint32_t kHeader = 4;
};

template <typename T>
T* made(T* entity) {
  if (entity == nullptr) throw std::runtime_error("cannot make a DDS entity");
  return entity;
}

dds::DomainParticipantQos loopbackOnly() {
  dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t loopback;
  rtps::IPLocator::setIPv4(loopback, "127.0.0.1");
  auto& builtin = qos.wire_protocol().builtin;
  builtin.initialPeersList.push_back(loopback);
  builtin.metatrafficUnicastLocatorList.push_back(loopback);
  builtin.discovery_config.leaseDuration_announcementperiod = {0, 200'000'000};
  return qos;
}

/// A participant that writes one topic and reads another.
class Peer : public dds::DataReaderListener {
 public:
  Peer(int domain, const char* writes, const char* reads, std::function<void(const Bytes&)> on_data)
      : on_data_(std::move(on_data)) {
    participant_ = made(dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<dds::DomainId_t>(domain), loopbackOnly()));
    // The client library has told the factory to leave that to it.
    participant_->enable();
    dds::TypeSupport type(new BytesType);
    type.register_type(participant_);
    const auto topic = [&](const char* name) {
      return made(participant_->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT));
    };
    auto* publisher = made(participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT));
    auto* subscriber = made(participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT));
    dds::DataWriterQos writer_qos = dds::DATAWRITER_QOS_DEFAULT;
    writer_qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    writer_qos.data_sharing().off();
    writer_ = made(publisher->create_datawriter(topic(writes), writer_qos));
    dds::DataReaderQos reader_qos = dds::DATAREADER_QOS_DEFAULT;
    reader_qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    reader_qos.data_sharing().off();
    reader_ = made(subscriber->create_datareader(topic(reads), reader_qos, this));
  }

  ~Peer() override {
    reader_->set_listener(nullptr);
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  void write(Bytes bytes) { writer_->write(bytes.data()); }

  void on_data_available(dds::DataReader* from) override {
    dds::SampleInfo info;
    Bytes bytes;
    while (from->take_next_sample(bytes.data(), &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) on_data_(bytes);
    }
  }

 private:
  std::function<void(const Bytes&)> on_data_;
  dds::DomainParticipant* participant_ = nullptr;
  dds::DataWriter* writer_ = nullptr;
  dds::DataReader* reader_ = nullptr;
};

constexpr const char* kPings = "bench/ping";
constexpr const char* kPongs = "bench/pong";

}  // namespace

void answerPings(int domain) {
  std::atomic<Peer*> peer = nullptr;
  Peer answering(domain, kPongs, kPings, [&peer](const Bytes& bytes) {
    if (Peer* there = peer) there->write(bytes);
  });
  peer = &answering;
  while (true) pause();
}

struct Ping::Impl {
  std::mutex mutex;
  std::condition_variable changed;
  std::uint32_t asked = 0, answered = 0;  // numbers of the last ping and pong, guarded by mutex
  Clock::time_point answered_at;
  Peer peer;

  explicit Impl(int domain)
      : peer(domain, kPings, kPongs, [this](const Bytes& pong) {
          const std::lock_guard lock(mutex);
          std::memcpy(&answered, pong.data(), sizeof(answered));
          answered_at = Clock::now();
          changed.notify_all();
        }) {}

  /// False when no answer to just this ping came in time.
  bool ask(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex);
    const std::uint32_t number = ++asked;
    lock.unlock();
    Bytes ping{};
    std::memcpy(ping.data(), &number, sizeof(number));
    peer.write(ping);
    lock.lock();
    return changed.wait_for(lock, most, [&] { return answered == number; });
  }
};

Ping::Ping(int domain, std::chrono::milliseconds wait) : impl_(std::make_unique<Impl>(domain)) {
  // Until both sides have matched, pings or their answers are lost.
  const auto until = Clock::now() + wait;
  while (!impl_->ask(std::chrono::milliseconds(50))) {
    if (Clock::now() > until) throw std::runtime_error("nobody answers pings");
  }
}

Ping::~Ping() = default;

std::chrono::duration<double> Ping::roundTrip() {
  const auto begin = Clock::now();
  if (!impl_->ask(std::chrono::seconds(5))) throw std::runtime_error("a ping was not answered");
  return impl_->answered_at - begin;
}

}  // namespace handover::bench
