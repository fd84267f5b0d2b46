// SPDX-License-Identifier: Apache-2.0
#include "verify/report.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>

namespace handover::verify {

std::string toText(const Report& report) {
  std::string text;
  for (const Violation& v : report.violations) {
    char time[32];
    std::snprintf(time, sizeof time, "%.3f", v.time);
    text +=
        (v.stage.empty() ? "plan" : v.stage) + " t=" + time + " " + v.kind + ": " + v.what + "\n";
  }
  return text;
}

std::string toJson(const Report& report) {
  nlohmann::ordered_json json;
  json["valid"] = report.valid();
  json["violations"] = nlohmann::ordered_json::array();
  for (const Violation& v : report.violations) {
    json["violations"].push_back({{"stage", v.stage},
                                  {"index", v.index},
                                  {"time", v.time},
                                  {"kind", v.kind},
                                  {"what", v.what},
                                  {"bodies", v.bodies}});
  }
  auto stages = nlohmann::ordered_json::array();
  for (const StageChecks& s : report.stages) {
    nlohmann::ordered_json entry = {
        {"stage", s.stage}, {"states", s.states}, {"pairs", s.pairs}, {"queries", s.queries}};
    entry["clearance"] = nullptr;
    if (std::isfinite(s.clearance)) entry["clearance"] = s.clearance;
    stages.push_back(entry);
  }
  json["checks"] = {{"stages", stages}};
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string unreadableJson(const std::string& what) {
  const nlohmann::ordered_json json = {
      {"valid", false}, {"unreadable", what}, {"violations", nlohmann::ordered_json::array()}};
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace handover::verify
