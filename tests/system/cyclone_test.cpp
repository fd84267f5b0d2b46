// SPDX-License-Identifier: Apache-2.0
// Another vendor's DDS, with types from the same IDL, against our daemon.
#include "process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover::test {
namespace {

using testing::HasSubstr;

class Cyclone : public testing::Test {
 protected:
  const int domain = freeDomain();
  Process daemon{{HANDOVER_BINARY_DIR "/tests/scripted_daemon", std::to_string(domain)}};

  Finished ask(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command{HANDOVER_BINARY_DIR "/tests/cyclone_client",
                                     std::to_string(domain)};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run(
        command,
        {"CYCLONEDDS_URI=<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="
         "'127.0.0.1' multicast='false'/></Interfaces><AllowMulticast>false</AllowMulticast>"
         "</General><Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>"
         "31</MaxAutoParticipantIndex><Peers><Peer Address='127.0.0.1'/></Peers></Discovery>"
         "<Internal><GenerateKeyhash>true</GenerateKeyhash></Internal>"
         "</Domain></CycloneDDS>"});
  }
};

TEST_F(Cyclone, ReadsTheStatusAndAWholeAnswer) {
  const auto client = ask({"script", "answer"});
  ASSERT_EQ(client.status, 0) << client.err << client.out;
  EXPECT_THAT(client.out, HasSubstr("status version 1 state 2 cell script revision 7\n"));
  EXPECT_THAT(client.out, HasSubstr("stage 0 payload 1\n"));
  EXPECT_THAT(
      client.out,
      HasSubstr("stage 1 payload 2 robot hubo q -0.33333333333333331 part 0.040000000000000001\n"));
  EXPECT_THAT(client.out, HasSubstr("stage 34 payload 7 q 0.33333333333333331 of 6\n"));
  EXPECT_THAT(client.out, HasSubstr("stage 35 payload 8 outcome 1\n"));
}

TEST_F(Cyclone, ReadsFailuresAndRejections) {
  const auto failed = ask({"script", "fail"});
  EXPECT_THAT(failed.out, HasSubstr("stage 1 payload 8 outcome 2\n")) << failed.err;
  const auto rejected = ask({"nowhere", "x"});
  EXPECT_EQ(rejected.status, 0) << rejected.err;
}

TEST_F(Cyclone, CancelAndDisposeEndARequest) {
  for (const char* how : {"cancel", "dispose"}) {
    const auto client = ask({"script", "hold", how});
    ASSERT_EQ(client.status, 0) << how << client.err << client.out;
    EXPECT_THAT(client.out, HasSubstr("stage 2 payload 8 outcome 3\n")) << how;
  }
}

}  // namespace
}  // namespace handover::test
