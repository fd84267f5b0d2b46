// SPDX-License-Identifier: Apache-2.0
#include "wire_checker.hpp"

#include "wire/codec.hpp"

#include <nlohmann/json.hpp>

#include <map>
#include <sstream>
#include <utility>

namespace handover::test {
namespace {

struct AnswerSoFar {
  wire::Guid writer{};
  std::uint32_t next = 0;
  int outcomes = 0, scenes = 0;
};

std::string placeOf(const PlanEvent& event) {
  return "request " + event.request_id.hex() + ", event " + std::to_string(event.sequence) + ": ";
}

/// The rule that an event breaks; empty for none.
std::string faultOf(const HeardEvent& heard, AnswerSoFar& answer) {
  const PlanEvent& event = heard.event;
  if (answer.next == 0) answer.writer = heard.writer;
  if (!wire::sameParticipant(answer.writer, heard.writer)) return "of another daemon";
  if (event.sequence != answer.next) return "after " + std::to_string(answer.next) + " events";
  if (answer.outcomes > 0) return "after the outcome";
  ++answer.next;
  answer.outcomes += std::holds_alternative<Outcome>(event.payload) ? 1 : 0;
  answer.scenes += std::holds_alternative<SceneSnapshot>(event.payload) ? 1 : 0;
  return answer.scenes > 1 ? "a second scene" : "";
}

}  // namespace

std::vector<std::string> wireFaults(const std::vector<HeardEvent>& heard) {
  std::map<std::pair<RequestId, AnswerId>, AnswerSoFar> answers;
  std::vector<std::string> faults;
  for (const HeardEvent& each : heard) {
    const std::string fault = faultOf(each, answers[{each.event.request_id, each.event.answer_id}]);
    if (!fault.empty()) faults.push_back(placeOf(each.event) + fault);
  }
  return faults;
}

WireRecorder::WireRecorder(int domain)
    : participant_({.domain = domain, .name = "recorder", .on_writer = {}}),
      reader_(participant_, {.partition = "*"}, [this](const auto& sample) {
        if (sample.message == nullptr) return;
        auto decoded = wire::decode(*sample.message);
        auto* event = std::get_if<PlanEvent>(&decoded);
        if (event == nullptr) return;
        const std::lock_guard lock(mutex_);
        heard_.push_back({std::move(*event), sample.writer});
      }) {}

std::vector<HeardEvent> WireRecorder::heard() const {
  const std::lock_guard lock(mutex_);
  return heard_;
}

std::string clientFault(int exit_code, const std::string& lines) {
  std::istringstream in(lines);
  std::uint32_t next = 0;
  int outcomes = 0;
  for (std::string line; std::getline(in, line);) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (!json.is_object()) return "no JSON: " + line.substr(0, 80);
    if (json.value("type", "") == "restart") {
      next = 0;
      outcomes = 0;
      continue;
    }
    if (!json.contains("sequence")) continue;  // why there is no answer
    if (json["sequence"] != next)
      return "event " + json["sequence"].dump() + " after " + std::to_string(next);
    ++next;
    outcomes += json.value("type", "") == "outcome" ? 1 : 0;
  }
  const bool answered = exit_code == 0 || (exit_code >= 10 && exit_code <= 12);
  if (!answered && exit_code != 13) return "exit " + std::to_string(exit_code);
  if (outcomes != (answered ? 1 : 0)) {
    return "exit " + std::to_string(exit_code) + " with " + std::to_string(outcomes) + " outcomes";
  }
  return "";
}

}  // namespace handover::test
