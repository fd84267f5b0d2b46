// SPDX-License-Identifier: Apache-2.0
#include "verify/report.hpp"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace handover::verify {
namespace {

using Json = nlohmann::ordered_json;

std::string nameOf(const Report& report, int stage) {
  const auto index = static_cast<std::size_t>(stage);
  return stage >= 0 && index < report.stage_names.size() ? report.stage_names[index] : "";
}

Json effortJson(const Effort& effort) {
  return {{"states", effort.states}, {"pairs", effort.pairs}, {"queries", effort.queries}};
}

Json qualityJson(const MeasuredQuality& quality) {
  Json clearance = Json::array();
  for (const auto& [between, found] : quality.clearance) {
    clearance.push_back({{"between", between},
                         {"least_m", found.least},
                         {"stage", found.stage < 0 ? Json() : Json(found.stage)},
                         {"pair", found.pair.empty() ? Json() : Json(found.pair)}});
  }
  Json json = {{"duration_s", quality.duration},
               {"bound_s", quality.bound},
               {"object_s", quality.object},
               {"idle_s", Json(quality.idle)},
               {"clearance", clearance},
               {"tilt_deg", quality.tilt_deg},
               {"object_turn_deg", {quality.turn_deg, quality.least_turn_deg}},
               {"limit_margin", nullptr},
               {"jerk_share", quality.jerk_share}};
  if (quality.limit_margin) json["limit_margin"] = *quality.limit_margin;
  return json;
}

}  // namespace

std::string toText(const Report& report) {
  std::string text;
  for (const Violation& v : report.violations) {
    char time[32];
    std::snprintf(time, sizeof time, "%.3f", v.time);
    text += v.stage < 0 ? "plan"
                        : "stage " + std::to_string(v.stage) + " (" + nameOf(report, v.stage) + ")";
    text += " t=" + std::string(time) + " " + v.kind + ": " + v.what + "\n";
  }
  return text;
}

std::string toJson(const Report& report) {
  Json json;
  json["valid"] = report.valid();
  json["violations"] = Json::array();
  for (const Violation& v : report.violations) {
    json["violations"].push_back({{"stage", v.stage < 0 ? Json() : Json(v.stage)},
                                  {"name", nameOf(report, v.stage)},
                                  {"time", v.time},
                                  {"kind", v.kind},
                                  {"what", v.what},
                                  {"bodies", v.bodies}});
  }
  json["checks"] = {{"nominal", effortJson(report.nominal)},
                    {"in_turn", effortJson(report.in_turn)},
                    {"late", effortJson(report.late)}};
  json["quality"] = report.quality ? qualityJson(*report.quality) : Json();
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string unreadableJson(const std::string& what) {
  const Json json = {{"valid", false}, {"unreadable", what}, {"violations", Json::array()}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace handover::verify
