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
  request.chain = {"crichton/left", "hubo"};
  request.overrides = {{"objects.cup.pose.xyz", "[1, 2, 3]"}, {"a.b", ""}};
  request.expected_revision = 0;
  request.expected_hash = "0123abcd";
  request.mode = SearchMode::kAll;
  request.search = SearchWidth::kPaper;
  request.objective = Objective::kTime;
  request.seed = 18446744073709551615ull;
  request.deadline_s = 0.25;
  request.speed_scale = 0.5;
  request.slack_s = 0.75;
  request.wants_fix = false;
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

template <typename Message>
std::vector<Fault> faultsOf(const Message& message) {
  const auto decoded = decode(message);
  const auto* faults = std::get_if<std::vector<Fault>>(&decoded);
  return faults == nullptr ? std::vector<Fault>{} : *faults;
}

PlanEvent eventOf(PlanEventPayload payload, std::uint32_t sequence = 0) {
  return {RequestId::random(), test::kSampleAnswer, sequence, 0.125, std::move(payload)};
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
  message.objective(msg::OBJECTIVE_UNSPECIFIED);
  const auto back = decode(message);
  ASSERT_TRUE(std::holds_alternative<PlanRequest>(back));
  EXPECT_EQ(std::get<PlanRequest>(back).mode, SearchMode::kBest);
  EXPECT_EQ(std::get<PlanRequest>(back).search, SearchWidth::kWide);
  EXPECT_EQ(std::get<PlanRequest>(back).objective, Objective::kUnspecified);
}

TEST(RequestCodec, ListsEveryFault) {
  auto message = encode(sampleRequest());
  message.version(2);
  message.client_id("Not OK");
  message.cell("");
  message.X_WO_goal().position().y(kNan);
  message.mode(static_cast<msg::SearchMode>(77));
  message.search(static_cast<msg::SearchWidth>(4));
  message.objective(static_cast<msg::ObjectiveKind>(5));
  message.chain({"a/b/c"});
  message.deadline_s(-1);
  message.speed_scale(kNan);
  message.slack_s(-0.25);
  const auto faults = faultsOf(message);
  for (const char* field : {"version", "client_id", "cell", "X_WO_goal.xyz", "mode", "search",
                            "objective", "chain[0]", "deadline_s", "speed_scale", "slack_s"}) {
    EXPECT_THAT(faults, names(field));
  }
  EXPECT_EQ(faults.size(), 11u);
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
        BadRequest{"object_name", [](auto& m) { m.object_name(std::string("a\0b", 3)); }},
        BadRequest{"chain", [](auto& m) { m.chain().assign(9, "hubo"); }},
        BadRequest{"chain[1]",
                   [](auto& m) {
                     m.chain({"hubo", "auto"});
                   }},
        BadRequest{"chain[0]", [](auto& m) { m.chain({""}); }},
        BadRequest{"chain[0]", [](auto& m) { m.chain({"/left"}); }},
        BadRequest{"chain[0]", [](auto& m) { m.chain({"hubo/"}); }},
        BadRequest{"expected_hash", [](auto& m) { m.expected_hash("xyz"); }},
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
        BadRequest{"slack_s", [](auto& m) { m.slack_s(10.5); }},
        BadRequest{"slack_s", [](auto& m) { m.slack_s(kNan); }},
        BadRequest{"extensions", [](auto& m) { m.extensions().resize(65); }}));

TEST(RequestCodec, TakesQuaternionsWithinAThousandthOfUnitLength) {
  PlanRequest request = sampleRequest();
  request.X_WO_goal->quat_wxyz = {0.9995, 0, 0, 0};
  EXPECT_TRUE(std::holds_alternative<PlanRequest>(decode(encode(request))));
  request.X_WO_goal->quat_wxyz = {0.998, 0, 0, 0};
  EXPECT_FALSE(std::holds_alternative<PlanRequest>(decode(encode(request))));
}

TEST(EventCodec, RoundTripsEveryPayload) {
  std::uint32_t sequence = 0;
  for (const PlanEventPayload& payload : test::samplePayloads()) {
    const PlanEvent event = eventOf(payload, sequence++);
    const auto back = decode(throughBytes<msg::PlanEventPubSubType>(encode(event)));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back))
        << sequence << describe(std::get<std::vector<Fault>>(back));
    EXPECT_EQ(std::get<PlanEvent>(back), event) << sequence;
  }
}

TEST(EventCodec, RoundTripsWhateverIsDrawn) {
  std::array<int, std::variant_size_v<PlanEventPayload>> drawn{};
  EXPECT_TRUE(test::holds("events", 600, [&] {
    const PlanEvent event = test::anyEvent();
    RC_ASSERT(check(event).empty());
    const auto back = decode(throughBytes<msg::PlanEventPubSubType>(encode(event)));
    RC_ASSERT(std::holds_alternative<PlanEvent>(back));
    RC_ASSERT(std::get<PlanEvent>(back) == event);
    ++drawn[event.payload.index()];
  }));
  EXPECT_THAT(drawn, testing::Each(testing::Gt(0)));
}

/// Every named enumerator in a payload that `make` makes of it.
template <typename Enum, typename Make>
void roundTripEach(Make make) {
  for (std::size_t i = 1; i < EnumNames<Enum>::value.size(); ++i) {
    const PlanEvent event = eventOf(make(static_cast<Enum>(i)));
    const auto back = decode(encode(event));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back)) << EnumNames<Enum>::value[i];
    EXPECT_EQ(std::get<PlanEvent>(back), event) << EnumNames<Enum>::value[i];
  }
}

TEST(EventCodec, RoundTripsEveryEnumerator) {
  roundTripEach<FailureReason>([](FailureReason reason) { return Outcome{Failed{reason, {}}}; });
  roundTripEach<RejectionReason>([](RejectionReason why) { return Outcome{Rejected{why, {}}}; });
  roundTripEach<CancelCause>([](CancelCause cause) { return Outcome{Cancelled{cause}}; });
  roundTripEach<StageAction>([](StageAction action) {
    StageTrajectory stage = test::sampleTrajectory(0, 0);
    stage.action = action;
    return stage;
  });
  roundTripEach<Cause>([](Cause cause) {
    Failed failed = test::sampleFailure();
    failed.explanation.causes = {{cause, {"a", "b"}, {}, 1}};
    return Outcome{failed};
  });
  roundTripEach<PruningPlace>([](PruningPlace place) { return GraspsPruned{.place = place}; });
  roundTripEach<TransportEnd>([](TransportEnd end) {
    SceneSnapshot scene = test::sampleScene();
    scene.goal.end = end;
    return scene;
  });
}

TEST(EventCodec, CarriesPlansOfOneToEightHolders) {
  for (std::uint32_t holders = 1; holders <= 8; ++holders) {
    const PlanEvent event = eventOf(test::sampleSolution(0, holders));
    const auto back = decode(throughBytes<msg::PlanEventPubSubType>(encode(event)));
    ASSERT_TRUE(std::holds_alternative<PlanEvent>(back)) << holders;
    EXPECT_EQ(std::get<PlanEvent>(back), event);
  }
  EXPECT_THAT(faultsOf(encode(eventOf(test::sampleSolution(0, 9)))), names("solution.holders"));
}

struct BadEvent {
  const char* field;
  PlanEventPayload payload;
};

template <typename Payload, typename Spoil>
BadEvent bad(const char* field, Payload payload, Spoil spoil) {
  spoil(payload);
  return {field, std::move(payload)};
}

/// Beyond the bounds as a value: check() finds it, and so does who decodes it.
TEST(EventCheck, NamesTheField) {
  const auto scene = [](const char* field, auto spoil) {
    return bad(field, test::sampleScene(), spoil);
  };
  const auto solution = [](const char* field, auto spoil) {
    return bad(field, test::sampleSolution(), spoil);
  };
  const auto stage = [](const char* field, auto spoil) {
    return bad(field, test::sampleTrajectory(0, 1), spoil);
  };
  const auto failure = [](const char* field, auto spoil) {
    return bad(field, Failure{FailureReason::kNoPath, test::sampleExplanation()}, spoil);
  };
  const auto workspaces = [](const char* field, auto spoil) {
    return bad(field, test::sampleWorkspaces(), spoil);
  };
  const BadEvent all[] = {
      scene("scene.robots[0].yaml_sha256", [](auto& s) { s.robots[0].yaml_sha256 = "ab"; }),
      scene("scene.robots[0].limits[0]", [](auto& s) { s.robots[0].limits[0].second.jerk = kInf; }),
      scene("scene.start.X_WO.xyz", [](auto& s) { s.start.X_WO.xyz[0] = kNan; }),
      scene("scene.goal.rest", [](auto& s) { s.goal.rest.none = true; }),
      scene("scene.upright.axis", [](auto& s) { s.upright->axis = {}; }),
      scene("scene.upright.within_deg", [](auto& s) { s.upright->within_deg = 181; }),
      solution("solution.X_WO_handovers", [](auto& s) { s.X_WO_handovers.clear(); }),
      solution("solution.stage_count", [](auto& s) { s.stage_count = 0; }),
      solution("solution.stage_count", [](auto& s) { s.stage_count = 129; }),
      solution("solution.slack_s", [](auto& s) { s.slack_s = 11; }),
      solution("solution.cost", [](auto& s) { s.cost = kInf; }),
      solution("solution.holders[1].dexterity.give",
               [](auto& s) { s.holders[1].dexterity.give = kNan; }),
      solution("solution.holders[0].hand.axis",
               [](auto& s) {
                 s.holders[0].gripper = SuctionGripper{"cup", {}, 0.02};
               }),
      solution("solution.quality.clearance[0].between",
               [](auto& s) { s.quality->clearance[0].between = "walls"; }),
      solution("solution.quality", [](auto& s) { s.quality->bound_s = kNan; }),
      stage("trajectory.t", [](auto& s) { s.t[1] = 0; }),
      stage("trajectory.t", [](auto& s) { s.t[0] = 0.1; }),
      stage("trajectory.index", [](auto& s) { s.index = 128; }),
      stage("trajectory.holder", [](auto& s) { s.holder = 8; }),
      stage("trajectory.after[0]", [](auto& s) { s.after[0].progress = -1; }),
      stage("trajectory.qdd", [](auto& s) { s.qdd[2][0] = kNan; }),
      failure("failure.reason", [](auto& f) { f.reason = FailureReason::kUnspecified; }),
      failure("failure.explanation.causes[1].cause",
              [](auto& f) { f.explanation.causes[1].cause = static_cast<Cause>(99); }),
      failure("failure.explanation.causes[3].stage.action",
              [](auto& f) { f.explanation.causes[3].stage->action = StageAction{}; }),
      failure("failure.explanation.farthest.X_WO.quat_wxyz",
              [](auto& f) { f.explanation.farthest->X_WO.quat_wxyz = {}; }),
      bad("note.code", Note{"", "text"}, [](auto&) {}),
      bad("fix.overrides[0].path", Fix{{{"", "1"}}, ""}, [](auto&) {}),
      bad("outcome.cause", Outcome{Cancelled{}}, [](auto&) {}),
      workspaces("workspaces.z", [](auto& w) { w.z = kNan; }),
      workspaces("workspaces.slices", [](auto& w) { w.slices.resize(17, w.slices[0]); }),
      workspaces("workspaces.slices[0].first", [](auto& w) { w.slices[0].first[1] = kInf; }),
      workspaces("workspaces.slices[0].scores", [](auto& w) { w.slices[0].scores.pop_back(); }),
      workspaces("workspaces.slices[0].scores", [](auto& w) { w.slices[0].scores[1] = -0.5; }),
      workspaces("workspaces.slices[0].scores",
                 [](auto& w) { w.slices[0].scores.resize(3 * 11'000); }),
      workspaces("workspaces.slices[1].scores", [](auto& w) { w.slices[1].scores = {0.5}; }),
      bad("accepted.scene_hash", Accepted{.scene_hash = "?"}, [](auto&) {}),
  };
  for (const BadEvent& it : all) {
    const auto faults = check(eventOf(it.payload));
    ASSERT_EQ(faults.size(), 1u) << it.field << describe(faults);
    EXPECT_EQ(faults[0].field, it.field);
  }
  PlanEvent nobodys = eventOf(Note{"a", "b"});
  nobodys.answer_id = {};
  EXPECT_THAT(check(nobodys), names("answer_id"));
}

TEST(EventCodec, RefusesWhatIsNoPayload) {
  auto nothing = encode(eventOf(Accepted{}));
  nothing.payload()._d() = msg::PAYLOAD_UNSPECIFIED;
  EXPECT_THAT(faultsOf(throughBytes<msg::PlanEventPubSubType>(nothing)), names("payload"));
  auto message = encode(eventOf(Outcome{Cancelled{CancelCause::kAsked}}));
  message.payload().outcome_value().kind(msg::OUTCOME_UNSPECIFIED);
  EXPECT_THAT(faultsOf(message), names("outcome.kind"));
  message.payload().outcome_value().kind(msg::OUTCOME_FAILED);
  EXPECT_THAT(faultsOf(message), names("outcome.reason"));
  message.payload().outcome_value().kind(msg::OUTCOME_REJECTED);
  EXPECT_THAT(faultsOf(message), names("outcome.reason"));
  auto solution = encode(eventOf(test::sampleSolution()));
  solution.payload().solution_value().holders()[0].gripper(static_cast<msg::GripperKind>(7));
  EXPECT_THAT(faultsOf(solution), names("solution.holders.gripper"));
}

TEST(EventCodec, RefusesRowsThatDoNotFit) {
  auto message = encode(eventOf(test::sampleTrajectory(0, 0)));
  message.payload().trajectory_value().q().pop_back();
  EXPECT_THAT(faultsOf(message), names("trajectory.q"));
  message = encode(eventOf(test::sampleTrajectory(0, 0)));
  message.payload().trajectory_value().qd()[1] = kNan;
  EXPECT_THAT(faultsOf(message), names("trajectory.qd"));
  message.payload().trajectory_value().qdd().clear();
  EXPECT_THAT(faultsOf(message), names("trajectory.qdd"));
  message.payload().trajectory_value().action(static_cast<msg::StageAction>(15));
  EXPECT_THAT(faultsOf(message), names("trajectory.action"));
}

TEST(EventCodec, RefusesALatticeBeyondItsBounds) {
  HandoverCandidates candidates;
  candidates.lattice.resize(4096);
  auto message = encode(eventOf(candidates));
  EXPECT_TRUE(faultsOf(throughBytes<msg::PlanEventPubSubType>(message)).empty());
  auto& lattice = message.payload().handover_candidates_value().lattice();
  lattice[7].centre().y(kInf);
  lattice[8].score(kNan);
  EXPECT_THAT(faultsOf(message), names("handover_candidates.lattice[7]"));
  EXPECT_THAT(faultsOf(message), names("handover_candidates.lattice[8]"));
  lattice.assign(4097, {});
  EXPECT_THAT(faultsOf(message), names("handover_candidates.lattice"));
}

TEST(EventCodec, RefusesStrangeGeometry) {
  const PlanEvent event = eventOf(test::sampleScene());
  auto message = encode(event);
  message.payload().scene_value().objects()[0].shape().parts()[0].kind(
      static_cast<msg::GeometryKind>(9));
  EXPECT_FALSE(faultsOf(message).empty());
  message = encode(event);
  message.payload().scene_value().objects()[0].shape().parts().clear();
  EXPECT_FALSE(faultsOf(message).empty());
  message = encode(event);
  message.payload().scene_value().objects()[1].shape().parts()[0].radius(kNan);
  EXPECT_FALSE(faultsOf(message).empty());
}

TEST(StatusCodec, RoundTrips) {
  DaemonStatus status{.id = RequestId::random().bytes, .version = "0.1.0"};
  status.state = DaemonState::kPreparing;
  status.cells = {{"butler", {"serve", "clear"}, 4, {}, "0123abcd"}, {"stool", {}, 1, {}, ""}};
  status.cells[0].variations = {{"a.xyz", {0, -1, 2}, {0.1, 1, 2}, {}, {}},
                                {"a.rpy_deg", {0, 0, -15}, {0, 0, 15}, {{0.5, -2}}, {}},
                                {"b", {}, {}, {}, {"1", "[2, 3]"}}};
  status.queued = 3;
  status.running = 2;
  status.counters = {10, 1, 2, 3, 4};
  status.refused = 5;
  status.clients = 6;
  status.memory_bytes = 1ull << 40;
  status.dropped_packets = 7;
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
