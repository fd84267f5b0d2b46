// SPDX-License-Identifier: Apache-2.0
#include "draw.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace handover::ctl {
namespace {

using client::Json;

/// The generator of a draw: the same numbers with every library, unlike the standard's.
SeededRandom generatorOf(const DrawId& id) {
  SeededRandom random(0);
  for (const std::uint64_t part : {id.seed, id.run, id.again}) {
    random = SeededRandom(random.bits() ^ part);
  }
  return random;
}

double between(double from, double to, double stretch, SeededRandom& random) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from) * stretch;
  if (half == 0) return middle;
  return std::clamp(middle + half * (2 * random.unit() - 1), middle - half, middle + half);
}

Json choice(const std::vector<std::string>& choices, SeededRandom& random) {
  const auto index = static_cast<std::size_t>(random.unit() * double(choices.size()));
  const std::string& text = choices[std::min(index, choices.size() - 1)];
  Json value = Json::parse(text, nullptr, false);
  return value.is_discarded() ? Json(text) : value;  // YAML that is no JSON stays as it is written
}

/// Adds to the yaw drawn the direction from the place drawn to the point that it faces.
void face(const Variation& variation, Json& drawn) {
  const Json& place = drawn.at(placePath(variation));
  const auto& [x, y] = *variation.facing;
  Json& yaw = drawn[variation.path][2];
  const double direction = std::atan2(y - place[1].get<double>(), x - place[0].get<double>());
  yaw = yaw.get<double>() + direction * 180 / std::numbers::pi;
}

}  // namespace

Json draw(const std::vector<Variation>& variations, const DrawId& id, double stretch) {
  SeededRandom random = generatorOf(id);
  Json drawn = Json::object();
  for (const Variation& variation : variations) {
    Json& value = drawn[variation.path];
    if (!variation.choices.empty()) {
      value = choice(variation.choices, random);
      continue;
    }
    value = Json::array();
    for (std::size_t i = 0; i < variation.from.size(); ++i) {
      value.push_back(between(variation.from[i], variation.to[i], stretch, random));
    }
    if (value.size() == 1) value = Json(value[0].get<double>());
  }
  for (const Variation& variation : variations) {
    if (variation.facing) face(variation, drawn);
  }
  return drawn;
}

std::vector<Override> overridesOf(const Json& drawn) {
  std::vector<Override> overrides;
  for (const auto& [path, value] : drawn.items()) {
    overrides.push_back(
        {path, value.is_string() ? value.get<std::string>() : client::compact(value)});
  }
  return overrides;
}

}  // namespace handover::ctl
