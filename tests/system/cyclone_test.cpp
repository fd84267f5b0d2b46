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
  EXPECT_THAT(client.out, HasSubstr("event 0 payload 1\n"));
  EXPECT_THAT(client.out, HasSubstr("event 1 payload 2 robot hubo q -0.33333333333333331 part "
                                    "0.040000000000000001 end 1\n"));
  EXPECT_THAT(client.out, HasSubstr("event 22 payload 6 holders 2 stages 16 cost 13.5 bound 10\n"));
  EXPECT_THAT(client.out, HasSubstr("event 38 payload 7 holder 1 action 9 qdd 0.5 of 6\n"));
  EXPECT_THAT(client.out, HasSubstr("event 39 payload 11 outcome 1 cancelled by 0\n"));
}

TEST_F(Cyclone, ReadsChainsOfThree) {
  const auto client = ask({"script", "three"});
  ASSERT_EQ(client.status, 0) << client.err << client.out;
  EXPECT_THAT(client.out, HasSubstr("event 5 payload 6 holders 3 stages 23 cost 14.5"));
  EXPECT_THAT(client.out, HasSubstr("event 53 payload 11 outcome 1"));
}

TEST_F(Cyclone, ReadsFailuresAndRejections) {
  const auto failed = ask({"script", "fail"});
  EXPECT_THAT(failed.out, HasSubstr("event 4 payload 9 reason 5 causes 4\n")) << failed.err;
  EXPECT_THAT(failed.out, HasSubstr("event 5 payload 12\n"));  // workspaces
  EXPECT_THAT(failed.out, HasSubstr("event 7 payload 11 outcome 2 cancelled by 0\n"));
  const auto rejected = ask({"nowhere", "x"});
  EXPECT_EQ(rejected.status, 0) << rejected.err;
}

TEST_F(Cyclone, CancelAndDisposeEndARequest) {
  for (const auto& [how, cause] : {std::pair{"cancel", 1}, {"dispose", 2}}) {
    const auto client = ask({"script", "hold", how});
    ASSERT_EQ(client.status, 0) << how << client.err << client.out;
    EXPECT_THAT(client.out,
                HasSubstr("event 2 payload 11 outcome 3 cancelled by " + std::to_string(cause)))
        << how;
  }
}

}  // namespace
}  // namespace handover::test
