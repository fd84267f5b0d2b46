// SPDX-License-Identifier: Apache-2.0
#include "wire/codec.hpp"

#include "any_events.hpp"
#include "property.hpp"
#include "sample_events.hpp"

#include <fastdds/rtps/common/SerializedPayload.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <handoverPubSubTypes.h>

#include <cmath>
#include <limits>

namespace handover::wire {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

PlanRequest sampleRequest() {
  PlanRequest request{.id = RequestId::random(), .client_id = "test_1-a", .cell = "butler"};
  request.task = "serve";
  request.object = "cup";
  request.X_WO_goal = test::samplePose(0.7);
  request.giver = "crichton";
  request.receiver = "hubo";
  request.giver_arm = "left";
  request.receiver_arm = "right";
  request.overrides = {{"objects.cup.pose.xyz", "[1, 2, 3]"}, {"a.b", ""}};
  request.expected_revision = 0;
  request.mode = SearchMode::kAll;
  request.search = SearchWidth::kPaper;
  request.seed = 18446744073709551615ull;
  request.deadline_s = 0.25;
  request.speed_scale = 0.5;
  return request;
}

/// Through the bytes of the wire.
template <typename Type, typename Message>
Message throughBytes(Message message) {
  Type type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(type.getSerializedSizeProvider(&message)());
  EXPECT_TRUE(type.serialize(&message, &payload));
  Message back;
  EXPECT_TRUE(type.deserialize(&payload, &back));
  return back;
}

std::vector<Fault> faultsOf(const msg::HandoverRequest& message) {
  const auto decoded = decode(message);
  const auto* faults = std::get_if<std::vector<Fault>>(&decoded);
  return faults == nullptr ? std::vector<Fault>{} : *faults;
}

std::vector<Fault> faultsOf(const msg::PlanEvent& message) {
  const auto decoded = decode(message);
  const auto* faults = std::get_if<std::vector<Fault>>(&decoded);
  return faults == nullptr ? std::vector<Fault>{} : *faults;
}

MATCHER_P(names, field, "") {
  return std::any_of(arg.begin(), arg.end(),
                     [&](const Fault& fault) { return fault.field == field; });
}

TEST(RequestCodec, RoundTrips) {
  const PlanRequest request = sampleRequest();
  const auto back = decode(throughBytes<msg::HandoverRequestPubSubType>(encode(request)));
  ASSERT_TRUE(std::holds_alternative<PlanRequest>(back));
  EXPECT_EQ(std::get<PlanRequest>(back), request);
}

TEST(RequestCodec, RoundTripsWhateverIsDrawn) {
  EXPECT_TRUE(test::holds("requests", 200, [] {
    const PlanRequest request = test::anyRequest();
    RC_ASSERT(check(request).empty());
    const auto back = decode(throughBytes<msg::HandoverRequestPubSubType>(encode(request)));
    RC_ASSERT(std::holds_alternative<PlanRequest>(back));
    RC_ASSERT(std::get<PlanRequest>(back) == request);
  }));
}

TEST(RequestCodec, KeepsWhatIsAbsentAbsent) {
  const PlanRequest request{.id = RequestId::random(), .client_id = "a", .cell = "c"};
  const auto back = decode(throughBytes<msg::HandoverRequestPubSubType>(encode(request)));
  ASSERT_TRUE(std::holds_alternative<PlanRequest>(back));
  EXPECT_EQ(std::get<PlanRequest>(back), request);
}

TEST(RequestCodec, TakesUnspecifiedModeAndSearchAsTheDefaults) {
  auto message = encode(sampleRequest());
  message.mode(msg::MODE_UNSPECIFIED);
  message.search(msg::SEARCH_UNSPECIFIED);
  const auto back = decode(message);
  ASSERT_TRUE(std::holds_alternative<PlanRequest>(back));
  EXPECT_EQ(std::get<PlanRequest>(back).mode, SearchMode::kBest);
  EXPECT_EQ(std::get<PlanRequest>(back).search, SearchWidth::kWide);
}

TEST(RequestCodec, ListsEveryFault) {
  auto message = encode(sampleRequest());
  message.version(2);
  message.client_id("Not OK");
  message.cell("");
  message.X_WO_goal().position().y(kNan);
  message.mode(static_cast<msg::SearchMode>(77));
  message.search(static_cast<msg::SearchWidth>(4));
  message.deadline_s(-1);
  message.speed_scale(kNan);
  const auto faults = faultsOf(message);
  for (const char* field : {"version", "client_id", "cell", "X_WO_goal.xyz", "mode", "search",
                            "deadline_s", "speed_scale"}) {
    EXPECT_THAT(faults, names(field));
  }
  EXPECT_EQ(faults.size(), 8u);
}

struct BadRequest {
  const char* field;
  std::function<void(msg::HandoverRequest&)> spoil;
};

class RequestFaults : public testing::TestWithParam<BadRequest> {};

TEST_P(RequestFaults, NameTheField) {
  auto message = encode(sampleRequest());
  GetParam().spoil(message);
  const auto faults = faultsOf(message);
  ASSERT_EQ(faults.size(), 1u) << GetParam().field;
  EXPECT_EQ(faults[0].field, GetParam().field);
  EXPECT_FALSE(faults[0].message.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Each, RequestFaults,
    testing::Values(
        BadRequest{"request_id", [](auto& m) { m.request_id({}); }},
        BadRequest{"client_id", [](auto& m) { m.client_id(""); }},
        BadRequest{"client_id", [](auto& m) { m.client_id("*"); }},
        BadRequest{"client_id", [](auto& m) { m.client_id(std::string(65, 'a')); }},
        BadRequest{"cell", [](auto& m) { m.cell(std::string(300, 'c')); }},
        BadRequest{"task", [](auto& m) { m.task(std::string(300, 't')); }},
        BadRequest{"giver", [](auto& m) { m.giver(std::string("a\0b", 3)); }},
        BadRequest{"X_WO_goal.quat_wxyz", [](auto& m) { m.X_WO_goal().orientation().w(0.7); }},
        BadRequest{"X_WO_goal.quat_wxyz", [](auto& m) { m.X_WO_goal().orientation() = {}; }},
        BadRequest{"X_WO_goal.quat_wxyz", [](auto& m) { m.X_WO_goal().orientation().x(kInf); }},
        BadRequest{"X_WO_goal.xyz", [](auto& m) { m.X_WO_goal().position().x(-kInf); }},
        BadRequest{"overrides", [](auto& m) { m.overrides().assign(257, m.overrides()[0]); }},
        BadRequest{"overrides[1].value",
                   [](auto& m) { m.overrides()[1].yaml_value(std::string(5000, '1')); }},
        BadRequest{"overrides[0].path", [](auto& m) { m.overrides()[0].path(""); }},
        BadRequest{"deadline_s", [](auto& m) { m.deadline_s(0); }},
        BadRequest{"deadline_s", [](auto& m) { m.deadline_s(kInf); }},
        BadRequest{"speed_scale", [](auto& m) { m.speed_scale(0); }},
        BadRequest{"speed_scale", [](auto& m) { m.speed_scale(1.001); }},
        BadRequest{"speed_scale", [](auto& m) { m.speed_scale(9e-4); }},
        BadRequest{"extensions", [](auto& m) { m.extensions().resize(65); }}));

TEST(RequestCodec, TakesQuaternionsWithinAThousandthOfUnitLength) {
  PlanRequest request = sampleRequest();
  request.X_WO_goal->quat_wxyz = {0.9995, 0, 0, 0};
  EXPECT_TRUE(std::holds_alternative<PlanRequest>(decode(encode(request))));
  request.X_WO_goal->quat_wxyz = {0.998, 0, 0, 0};
  EXPECT_FALSE(std::holds_alternative<PlanRequest>(decode(encode(request))));
}

TEST(StageCodec, RoundTripsEveryPayload) {
  std::uint32_t sequence = 0;
  for (const PlanEventPayload& payload : test::samplePayloads()) {
    const PlanEvent stage{RequestId::random(), sequence++, 0.125, payload};
    const auto back = decode(throughBytes<msg::PlanStagePubSubType>(encode(stage)));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back)) << sequence;
    EXPECT_EQ(std::get<PlanEvent>(back), stage) << sequence;
  }
}

TEST(StageCodec, RoundTripsWhateverIsDrawn) {
  std::array<int, std::variant_size_v<PlanEventPayload>> drawn{};
  EXPECT_TRUE(test::holds("stages", 400, [&] {
    const PlanEvent stage = test::anyStage();
    RC_ASSERT(check(stage).empty());
    const auto back = decode(throughBytes<msg::PlanStagePubSubType>(encode(stage)));
    RC_ASSERT(std::holds_alternative<PlanEvent>(back));
    RC_ASSERT(std::get<PlanEvent>(back) == stage);
    ++drawn[stage.payload.index()];
  }));
  EXPECT_THAT(drawn, testing::Each(testing::Gt(0)));
}

TEST(StageCodec, RoundTripsEveryReasonAndKind) {
  for (int reason = 1; reason <= static_cast<int>(FailureReason::kInternal); ++reason) {
    const PlanEvent stage{RequestId::random(), 0, 0,
                          Outcome{Failed{static_cast<FailureReason>(reason), {}}}};
    const auto back = decode(encode(stage));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back)) << reason;
    EXPECT_EQ(std::get<PlanEvent>(back), stage) << reason;
  }
  for (const char* reason : {"bad_request", "unknown_cell", "busy", "scene_changed"}) {
    const PlanEvent stage{RequestId::random(), 0, 0, Outcome{Rejected{reason, {}}}};
    const auto back = decode(encode(stage));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back)) << reason;
    EXPECT_EQ(std::get<PlanEvent>(back), stage) << reason;
  }
  for (int i = 0; i < kStageCount; ++i) {
    const PlanEvent stage{RequestId::random(), 0, 0, test::sampleTrajectory(0, i)};
    const auto back = decode(encode(stage));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back)) << i;
    EXPECT_EQ(std::get<PlanEvent>(back), stage) << i;
  }
}

TEST(StageCodec, RefusesWhatIsNoPayload) {
  auto nothing = encode(PlanEvent{RequestId::random(), 0, 0, Accepted{}});
  nothing.payload()._d() = msg::PAYLOAD_UNSPECIFIED;
  EXPECT_THAT(faultsOf(throughBytes<msg::PlanStagePubSubType>(nothing)), names("payload"));
  auto message = encode(PlanEvent{RequestId::random(), 0, 0, Outcome{Cancelled{}}});
  message.payload().outcome_value().kind(msg::OUTCOME_UNSPECIFIED);
  EXPECT_THAT(faultsOf(message), names("outcome.kind"));
  message.payload().outcome_value().kind(msg::OUTCOME_FAILED);
  EXPECT_THAT(faultsOf(message), names("outcome.reason"));
  message.payload().outcome_value().kind(msg::OUTCOME_REJECTED);
  EXPECT_THAT(faultsOf(message), names("outcome.reason"));
}

TEST(StageCodec, RefusesRowsThatDoNotFit) {
  auto message = encode(PlanEvent{RequestId::random(), 0, 0, test::sampleTrajectory(0, 0)});
  message.payload().trajectory_value().q().pop_back();
  EXPECT_THAT(faultsOf(message), names("trajectory.q"));
  message = encode(PlanEvent{RequestId::random(), 0, 0, test::sampleTrajectory(0, 0)});
  message.payload().trajectory_value().qd()[1] = kNan;
  EXPECT_THAT(faultsOf(message), names("trajectory.qd"));
  message.payload().trajectory_value().kind(static_cast<msg::StageKind>(15));
  EXPECT_THAT(faultsOf(message), names("trajectory.kind"));
}

TEST(StageCodec, RefusesALatticeBeyondItsBounds) {
  HandoverCandidates candidates{.giver_arm = "left", .receiver_arm = "right"};
  candidates.lattice.resize(4096);
  auto message = encode(PlanEvent{RequestId::random(), 0, 0, candidates});
  EXPECT_TRUE(faultsOf(throughBytes<msg::PlanStagePubSubType>(message)).empty());
  auto& lattice = message.payload().handover_candidates_value().lattice();
  lattice[7].centre().y(kInf);
  lattice[8].score(kNan);
  EXPECT_THAT(faultsOf(message), names("handover_candidates.lattice[7]"));
  EXPECT_THAT(faultsOf(message), names("handover_candidates.lattice[8]"));
  lattice.assign(4097, {});
  EXPECT_THAT(faultsOf(message), names("handover_candidates.lattice"));
}

TEST(StageCodec, RefusesStrangeGeometry) {
  const PlanEvent stage{RequestId::random(), 0, 0, test::sampleScene()};
  auto message = encode(stage);
  message.payload().scene_value().objects()[0].shape().parts()[0].kind(
      static_cast<msg::GeometryKind>(9));
  EXPECT_FALSE(faultsOf(message).empty());
  message = encode(stage);
  message.payload().scene_value().objects()[0].shape().parts().clear();
  EXPECT_FALSE(faultsOf(message).empty());
  message = encode(stage);
  message.payload().scene_value().objects()[1].shape().parts()[0].radius(kNan);
  EXPECT_FALSE(faultsOf(message).empty());
}

TEST(StatusCodec, RoundTrips) {
  DaemonStatus status{.id = RequestId::random().bytes, .version = "0.1.0"};
  status.state = DaemonState::kPreparing;
  status.cells = {{"butler", {"serve", "clear"}, 4, {}}, {"stool", {}, 1, {}}};
  status.cells[0].variations = {{"a.xyz", {0, -1, 2}, {0.1, 1, 2}, {}, {}},
                                {"a.rpy_deg", {0, 0, -15}, {0, 0, 15}, {{0.5, -2}}, {}},
                                {"b", {}, {}, {}, {"1", "[2, 3]"}}};
  status.queued = 3;
  status.running = 2;
  status.counters = {10, 1, 2, 3, 4};
  const auto back = decode(throughBytes<msg::DaemonStatusPubSubType>(encode(status)));
  ASSERT_TRUE(std::holds_alternative<DaemonStatus>(back));
  EXPECT_EQ(std::get<DaemonStatus>(back), status);
}

TEST(StatusCodec, RefusesVariationsThatNobodyCouldDraw) {
  DaemonStatus status{.id = {}, .version = "1", .state = DaemonState::kReady};
  const auto readable = [&status](const Variation& variation) {
    status.cells = {{"c", {}, 1, {variation}}};
    return std::holds_alternative<DaemonStatus>(decode(encode(status)));
  };
  EXPECT_TRUE(readable({"a", {0}, {1}, {}, {}}));
  EXPECT_FALSE(readable({"", {0}, {1}, {}, {}}));
  EXPECT_FALSE(readable({"a", {0}, {1, 2}, {}, {}}));
  EXPECT_FALSE(readable({"a", {0}, {kInf}, {}, {}}));
  EXPECT_FALSE(readable({"a", {}, {}, {}, {}}));
  EXPECT_FALSE(readable({"a", {0}, {1}, {}, {"2"}}));
  EXPECT_FALSE(readable({"a", {0}, {1}, {{0, 0}}, {}}));
  EXPECT_FALSE(readable({"a", {0, 0, 0}, {0, 0, 1}, {{0, kNan}}, {}}));
  EXPECT_FALSE(readable({"a", std::vector<double>(65), std::vector<double>(65), {}, {}}));
}

TEST(StatusCodec, RoundTripsWhateverIsDrawn) {
  EXPECT_TRUE(test::holds("statuses", 100, [] {
    const DaemonStatus status = test::anyStatus();
    const auto back = decode(throughBytes<msg::DaemonStatusPubSubType>(encode(status)));
    RC_ASSERT(std::holds_alternative<DaemonStatus>(back));
    RC_ASSERT(std::get<DaemonStatus>(back) == status);
  }));
}

TEST(StatusCodec, RefusesAnUnknownState) {
  auto message = encode(DaemonStatus{.id = {}, .version = "1", .state = DaemonState::kReady});
  message.state(static_cast<msg::DaemonState>(9));
  EXPECT_FALSE(std::holds_alternative<DaemonStatus>(decode(message)));
}

TEST(CancelCodec, RoundTrips) {
  const RequestId id = RequestId::random();
  const auto back = decode(throughBytes<msg::HandoverCancelPubSubType>(encodeCancel(id)));
  ASSERT_TRUE(std::holds_alternative<RequestId>(back));
  EXPECT_EQ(std::get<RequestId>(back), id);
}

}  // namespace
}  // namespace handover::wire
