// SPDX-License-Identifier: Apache-2.0
// A daemon that nobody can reach does not say that it serves.
#include "process.hpp"

#include <gmock/gmock.h>
#include <signal.h>

namespace handover::test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kDaemon = HANDOVER_BINARY_DIR "/tests/scripted_daemon";

/// A shell script in a network namespace of its own, whose loopback interface is down.
std::vector<std::string> inNewNetwork(const std::string& script) {
  return {"/usr/bin/unshare", "-n", "/bin/sh", "-c", script};
}

class Start : public testing::Test {
 protected:
  void SetUp() override {
    if (run(inNewNetwork("exit 0")).status != 0) GTEST_SKIP() << "no right to a network namespace";
  }

  const std::string domain_ = std::to_string(freeDomain());
};

TEST_F(Start, WithoutALoopbackInterfaceIsGivenUp) {
  const auto finished = run(inNewNetwork("exec " + kDaemon + " " + domain_ + " 3000"));
  EXPECT_EQ(finished.status, 4);
  EXPECT_THAT(finished.err, HasSubstr("nobody can reach this daemon"));
  EXPECT_THAT(finished.err, Not(HasSubstr("serving")));
}

TEST_F(Start, WaitsForALoopbackInterfaceThatComesLate) {
  Process daemon(
      inNewNetwork("(sleep 1; ip link set lo up) & exec " + kDaemon + " " + domain_ + " 60000"));
  ASSERT_TRUE(daemon.waitForOutput("trying again"));
  ASSERT_TRUE(daemon.waitForOutput("serving"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(5s), 0);
}

TEST_F(Start, EndsWhenTheLoopbackInterfaceGoes) {
  Process daemon(inNewNetwork("ip link set lo up; (sleep 6; ip link set lo down) & exec " +
                              kDaemon + " " + domain_ + " 5000"));
  ASSERT_TRUE(daemon.waitForOutput("serving"));
  EXPECT_EQ(daemon.wait(30s), 4);
  EXPECT_THAT(daemon.err(), HasSubstr("nobody can reach this daemon any more"));
}

TEST_F(Start, EndsSoAlsoWhenItsStopHangs) {
  const std::string ask = HANDOVER_BINARY_DIR "/bin/handoverctl plan --cell script --task stuck";
  Process daemon(inNewNetwork("ip link set lo up; " + ask + " --wait 10 --domain " + domain_ +
                              " >/dev/null 2>&1 & (sleep 6; ip link set lo down) & exec " +
                              kDaemon + " " + domain_ + " 4000"));
  ASSERT_TRUE(daemon.waitForOutput("serving"));
  EXPECT_EQ(daemon.wait(40s), 4);
  EXPECT_THAT(daemon.err(), HasSubstr("the stop hangs and is cut short"));
}

TEST_F(Start, WithTooFewFileDescriptorsIsGivenUp) {
  const auto finished =
      run({"/bin/sh", "-c", "ulimit -n 8; exec " + kDaemon + " " + domain_ + " 2000"});
  EXPECT_EQ(finished.status, 4);
  EXPECT_THAT(finished.err, Not(HasSubstr("serving")));
}

}  // namespace
}  // namespace handover::test
