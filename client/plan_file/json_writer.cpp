// SPDX-License-Identifier: Apache-2.0
#include "plan_file/json_writer.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace handover::client {
namespace {

std::string number(double value) {
  if (!std::isfinite(value)) throw std::logic_error("JSON has no number that is not finite");
  char buffer[32];
  const auto [end, code] = std::to_chars(std::begin(buffer), std::end(buffer), value);
  std::string text(buffer, end);
  // Keeps 1.0 a floating-point number for readers that tell them apart.
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string scalar(const Json& json) {
  if (json.is_number_float()) return number(json.get<double>());
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string quoted(const std::string& key) { return scalar(Json(key)); }

void line(const Json& json, const char* between, std::string& out) {
  if (!json.is_structured()) {
    out += scalar(json);
    return;
  }
  out += json.is_object() ? '{' : '[';
  bool first = true;
  for (auto it = json.begin(); it != json.end(); ++it) {
    if (!first) out += between;
    first = false;
    if (json.is_object()) out += quoted(it.key()) + ": ";
    line(*it, between, out);
  }
  out += json.is_object() ? '}' : ']';
}

bool plainList(const Json& json) {
  return json.is_array() && std::none_of(json.begin(), json.end(),
                                         [](const Json& item) { return item.is_structured(); });
}

void block(const Json& json, std::size_t indent, std::string& out) {
  std::string flat;
  line(json, ", ", flat);
  if (flat.size() + indent <= 100 || !json.is_structured() || plainList(json)) {
    out += flat;
    return;
  }
  const std::string margin(indent + 2, ' ');
  out += json.is_object() ? "{\n" : "[\n";
  for (auto it = json.begin(); it != json.end(); ++it) {
    if (it != json.begin()) out += ",\n";
    out += margin;
    if (json.is_object()) out += quoted(it.key()) + ": ";
    block(*it, indent + 2, out);
  }
  out += '\n' + std::string(indent, ' ') + (json.is_object() ? '}' : ']');
}

}  // namespace

std::string compact(const Json& json) {
  std::string out;
  line(json, ", ", out);
  return out;
}

std::string pretty(const Json& json) {
  std::string out;
  block(json, 0, out);
  return out;
}

}  // namespace handover::client
