// SPDX-License-Identifier: Apache-2.0
// Datagrams that end or freeze Fast DDS 2.9.1, sent to a live daemon: it goes on.
#include "process.hpp"
#include "rtps_packets.hpp"
#include "wire/entities.hpp"

#include <handover/client/client.hpp>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <random>

namespace handover::test {
namespace {

using client::Client;

/// A request writer that the daemon knows, and its GUID.
class KnownWriter {
 public:
  explicit KnownWriter(int domain)
      : participant_({.domain = domain, .name = "known", .on_writer = {}}),
        own_(participant_, {},
             [this](const wire::Sample<msg::HandoverRequest>& sample) {
               const std::lock_guard lock(mutex_);
               guid_ = sample.writer;
               changed_.notify_all();
             }),
        requests_(participant_, {.on_match = [this](const wire::Match& match) {
                    const std::lock_guard lock(mutex_);
                    peers_ = match.current;
                    changed_.notify_all();
                  }}) {}

  /// Waits until the daemon and this process have matched it.
  wire::Guid guid() {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, 20s, [this] { return peers_ >= 2; }));
    lock.unlock();
    EXPECT_EQ(requests_.write({}), wire::WriteResult::kOk);
    lock.lock();
    EXPECT_TRUE(changed_.wait_for(lock, 20s, [this] { return guid_ != wire::Guid{}; }));
    return guid_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  wire::Guid guid_{};
  int peers_ = 0;
  wire::Participant participant_;
  wire::Reader<msg::HandoverRequest> own_;
  wire::Writer<msg::HandoverRequest> requests_;
};

class Packets : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(daemon_.waitForOutput("serving")); }

  void TearDown() override { close(socket_); }

  /// To a port of the daemon, the first participant of its domain.
  void sendTo(int port, const Bytes& datagram) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port + 250 * domain_));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(sendto(socket_, datagram.data(), datagram.size(), 0,
                     reinterpret_cast<const sockaddr*>(&to), sizeof(to)),
              static_cast<ssize_t>(datagram.size()));
  }

  static constexpr int kDiscovery = 7410, kUsers = 7411;

  void send(const Bytes& datagram) {
    for (const int port : {kDiscovery, kUsers}) sendTo(port, datagram);
  }

  /// A participant a millisecond, for so long; each leaves, or not, when its lease of 100 ms ends.
  void comeAndGo(std::chrono::seconds time, bool leave) {
    using Clock = std::chrono::steady_clock;
    std::mt19937 random(1);
    std::deque<std::pair<Clock::time_point, std::array<std::uint8_t, 12>>> there;
    const auto end = Clock::now() + time;
    for (auto next = Clock::now(); next < end; next += 1ms) {
      std::array<std::uint8_t, 12> prefix{1, 15};
      for (std::size_t i = 2; i < prefix.size(); ++i) {
        prefix[i] = static_cast<std::uint8_t>(random());
      }
      sendTo(kDiscovery, announcement({.from = prefix, .lease = 100ms, .endpoints = 1}));
      there.emplace_back(Clock::now() + 100ms + std::chrono::microseconds(random() % 2000), prefix);
      for (; there.front().first <= Clock::now(); there.pop_front()) {
        if (leave) sendTo(kDiscovery, departure(there.front().second));
      }
      std::this_thread::sleep_until(next);
    }
  }

  /// A fresh client's plan.
  Outcome plan() {
    Client client({.domain = domain_, .client_id = {}, .wait = 5s});
    PlanRequest request;
    request.cell = "script";
    request.task = "answer";
    return client.plan(request).wait();
  }

  std::uint64_t dropped() {
    Client client({.domain = domain_, .client_id = {}, .wait = 5s});
    return client.daemons().at(0).dropped_packets;
  }

  const int domain_ = freeDomain();
  Process daemon_{{HANDOVER_BINARY_DIR "/tests/scripted_daemon", std::to_string(domain_)}};
  const int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(Packets, OfOrdinaryClientsAreNotDropped) {
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(std::holds_alternative<Done>(plan()));
  EXPECT_EQ(dropped(), 0u);
}

TEST_F(Packets, ThatEndTheLibraryDoNotReachIt) {
  send(datagram({statistics(), submessage(0x09, Bytes(2))}));
  EXPECT_TRUE(std::holds_alternative<Done>(plan()));
  EXPECT_GE(dropped(), 2u);
}

TEST_F(Packets, OfAKnownWriterThatSpinItsThreadDoNotReachIt) {
  KnownWriter writer(domain_);
  const wire::Guid guid = writer.guid();
  std::array<std::uint8_t, 12> from{};
  std::copy_n(guid.begin(), 12, from.begin());
  EntityId id{};
  std::copy_n(guid.begin() + 12, 4, id.begin());
  for (const Bytes& hostile :
       {gap(1, 1ll << 52, id), gap(1, 0, id), heartbeat(1ll << 52, 1ll << 53, 1000, id),
        heartbeat(0, -1, 1001, id), heartbeat(1, INT64_MAX, 1002, id),
        heartbeat((1 << 24) - 1, 1 << 30, 1003, id)}) {
    send(datagram({hostile}, from));
  }
  EXPECT_TRUE(std::holds_alternative<Done>(plan()));
  EXPECT_GE(dropped(), 12u);
  daemon_.signal(SIGTERM);
  EXPECT_EQ(daemon_.wait(5s), 0);
}

/// Unguarded, the daemon ends within a second (ParticipantLeases).
TEST_F(Packets, OfParticipantsThatLeaveAsTheirLeaseEndsDoNotEndIt) {
  comeAndGo(3s, true);
  EXPECT_TRUE(std::holds_alternative<Done>(plan()));
  EXPECT_EQ(dropped(), 0u);
  daemon_.signal(SIGTERM);
  EXPECT_EQ(daemon_.wait(5s), 0);
}

/// Not a daemon's: discovery's thread is held up by a callback.
TEST(ReceivingThread, ThatHangsInADatagramIsSeen) {
  const int domain = freeDomain();
  std::atomic<bool> held = false;
  std::atomic<bool> released = false;
  wire::Participant participant(
      {.domain = domain, .name = "held", .on_writer = [&](const wire::RemoteWriter&) {
         held = true;
         released.wait(false);
       }});
  wire::Participant other({.domain = domain, .name = "other", .on_writer = {}});
  wire::Writer<msg::HandoverRequest> writer(other, {});
  const auto eventually = [](auto condition) {
    const auto until = std::chrono::steady_clock::now() + 20s;
    while (!condition() && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(1ms);
    }
    return condition();
  };
  EXPECT_TRUE(eventually([&] { return held.load(); }));
  EXPECT_TRUE(eventually([&] { return participant.atOneDatagram() > 300ms; }));
  EXPECT_LT(other.atOneDatagram(), 300ms);
  released = true;
  released.notify_all();
  EXPECT_TRUE(eventually([&] { return participant.atOneDatagram() < 300ms; }));
}

}  // namespace
}  // namespace handover::test
