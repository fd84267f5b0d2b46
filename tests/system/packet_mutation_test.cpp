// SPDX-License-Identifier: Apache-2.0
// Live traffic between a client and the daemon, changed by seed and sent to the daemon while fresh
// clients plan: the daemon lives, each request ends in time, and afterwards all is as before.
// HANDOVER_PACKETS: how many a seed (default: 500); HANDOVER_PACKET_SEEDS: how many seeds (1),
// HANDOVER_PACKET_SEED: the first (1).
#include "packet_mutator.hpp"
#include "process.hpp"
#include "sent_packets.hpp"
#include "temporary_folder.hpp"
#include "verified.hpp"

#include <handover/client/client.hpp>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <iostream>
#include <map>
#include <set>
#include <thread>

namespace handover::test {
namespace {

using client::Client;
using Clock = std::chrono::steady_clock;

const std::string kBin = HANDOVER_BINARY_DIR "/bin/";

int fromEnvironment(const char* name, int otherwise) {
  const char* given = std::getenv(name);
  return given == nullptr ? otherwise : std::atoi(given);
}

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

/// Of a request: to find a daemon, and to be answered.
constexpr int kWaitS = 4, kDeadlineS = 4;
/// A program's start and end, on a busy machine.
constexpr auto kProgram = 20s;
/// After the last packet a fresh client has its plan within this, or within three times what it
/// took before the first one, where the machine is busy with other things.
constexpr Clock::duration kRecovered = 2s;

class PacketMutation : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { ASSERT_TRUE(daemon_->waitForOutput("serving", 60s)); }

  void TearDown() override { close(socket_); }

  /// To the daemon, the first participant of its domain. Recorded datagrams that went to discovery
  /// (an even port) or users go to its port for that.
  void send(const Bytes& datagram, int recorded_port) const {
    const Unrecorded unrecorded;
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(7410 + 250 * domain_ + recorded_port % 2));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    (void)sendto(socket_, datagram.data(), datagram.size(), 0,
                 reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  }

  /// A fresh client's plan, verified where there is one: the exit code. Fails the test when it does
  /// not end in the client's own time.
  int planOfFreshClient() {
    const TemporaryFolder folder;
    const auto file = folder / "plan.json";
    const auto began = Clock::now();
    Process planning(words(kBin +
                           "handoverctl plan --cell butler --mode first --no-fix --deadline " +
                           std::to_string(kDeadlineS) + " --wait " + std::to_string(kWaitS) +
                           " --domain " + std::to_string(domain_) + " --output " + file.string()));
    const auto code = planning.wait(std::chrono::seconds(kWaitS + kDeadlineS) + kProgram);
    if (!code) {
      ADD_FAILURE() << "a client waits beyond its own time limit\n"
                    << planning.out() << planning.err();
      return -1;
    }
    EXPECT_TRUE(std::set({0, 10, 11, 12, 13}).contains(*code)) << *code << ": " << planning.err();
    took_ = Clock::now() - began;
    if (*code == 0) {
      EXPECT_TRUE(verifiedFile(file, HANDOVER_SOURCE_DIR));
    }
    return *code;
  }

  /// The client whose traffic is recorded: what comes of its requests, once they have ended.
  void planAlong(Client& client) {
    PlanRequest request;
    request.cell = "butler";
    request.mode = SearchMode::kFirst;
    request.deadline_s = kDeadlineS;
    request.wants_fix = false;
    try {
      const auto handle = client.plan(request);
      EXPECT_TRUE(handle.waitFor(std::chrono::seconds(kWaitS + kDeadlineS) + kProgram));
      handle.wait();
    } catch (const client::ClientError&) {
      // Its own stream may be cut by what is sent in its name.
    }
  }

  /// Sends `count` mutants of what the client sends, five hundred a second at most, while it goes
  /// on.
  void sendMutants(Client& client, PacketMutator& mutator, int count) {
    std::jthread planning([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) planAlong(client);
    });
    SeededRandom choice(static_cast<std::uint64_t>(GetParam()));
    std::vector<Bytes> recorded;
    std::vector<int> ports;
    auto next = Clock::now();
    for (int i = 0; i < count; ++i) {
      if (i % 500 == 0) take(recorded, ports);
      const std::size_t from = choice.index(static_cast<std::uint32_t>(recorded.size()));
      send(mutator.mutant(recorded[from], recorded), ports[from]);
      std::this_thread::sleep_until(next += 2ms);
    }
  }

  void take(std::vector<Bytes>& recorded, std::vector<int>& ports) {
    recorded.clear();
    ports.clear();
    for (SentPacket& packet : sentPackets()) {
      for (const std::uint8_t kind : kindsOf(packet.bytes)) ++kinds_[kind];
      ports.push_back(packet.port);
      recorded.push_back(std::move(packet.bytes));
    }
    ASSERT_FALSE(recorded.empty());
  }

  const int domain_ = freeDomain();
  std::unique_ptr<Process> daemon_ = std::make_unique<Process>(
      words(kBin + "handoverd serve --cell butler --root " HANDOVER_SOURCE_DIR " --domain " +
            std::to_string(domain_)),
      std::vector<std::string>{"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"});
  const int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  std::map<int, int> kinds_;
  Clock::duration took_{};
};

TEST_P(PacketMutation, OfLiveTrafficLeavesTheDaemonAndItsClientsWell) {
  const int count = fromEnvironment("HANDOVER_PACKETS", 500);
  std::cout << "seed " << GetParam() << ", " << count << " packets, daemon in domain " << domain_
            << std::endl;
  ASSERT_EQ(planOfFreshClient(), 0);
  const Clock::duration before = took_;
  forgetSentPackets();
  std::map<int, int> codes;
  {
    Client client({.domain = domain_, .client_id = {}, .wait = 4s, .silence = 8s});
    planAlong(client);
    std::jthread fresh([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) ++codes[planOfFreshClient()];
    });
    PacketMutator mutator(static_cast<std::uint64_t>(GetParam()));
    sendMutants(client, mutator, count);
  }
  EXPECT_EQ(planOfFreshClient(), 0) << daemon_->err();
  EXPECT_LT(took_, std::max(kRecovered, 3 * before));
  std::cout << "a fresh client's plan took " << seconds(before) << " s before, " << seconds(took_)
            << " s after\n";
  for (const int kind : {0x06, 0x07, 0x0e, 0x15}) EXPECT_GT(kinds_[kind], 0) << kind;
  for (const auto& [code, times] : codes) std::cout << "exit " << code << ": " << times << '\n';
  daemon_->signal(SIGTERM);
  EXPECT_EQ(daemon_->wait(5s), 0) << daemon_->err();
}

INSTANTIATE_TEST_SUITE_P(Seeds, PacketMutation,
                         testing::Range(fromEnvironment("HANDOVER_PACKET_SEED", 1),
                                        fromEnvironment("HANDOVER_PACKET_SEED", 1) +
                                            fromEnvironment("HANDOVER_PACKET_SEEDS", 1)));

}  // namespace
}  // namespace handover::test
