// SPDX-License-Identifier: Apache-2.0
// Spoiled files get an answer, never a crash or an exception of another kind.
#include "gantry_plan.hpp"
#include "verify/plan_file.hpp"
#include "verify/unreadable.hpp"
#include "verify/verifier.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace handover::verify {
namespace {

using test::Json;

TEST(PlanReader, SurvivesSpoiledBytes) {
  const test::GantryCell cell;
  const std::string right = cell.plan().dump();
  std::mt19937 random(11);
  int unreadable = 0;
  for (int i = 0; i < 400; ++i) {
    std::string text = right;
    for (unsigned k = 0; k <= random() % 3; ++k) {
      text[random() % text.size()] = static_cast<char>(random() % 256);
    }
    try {
      parsePlan(text);
    } catch (const Unreadable&) {
      ++unreadable;
    }
  }
  EXPECT_GT(unreadable, 200);
}

/// All values of the document, to spoil one of them.
void collect(Json& value, std::vector<Json*>& all) {
  all.push_back(&value);
  if (value.is_structured()) {
    for (Json& child : value) collect(child, all);
  }
}

TEST(Verifier, SurvivesSpoiledValues) {
  const test::GantryCell cell;
  std::mt19937 random(5);
  const std::vector<Json> values = {nullptr, true,           -1, 0,     1e5,
                                    -1e5,    1e-300,         "", "box", Json::array(),
                                    {1, 2},  Json::object(), "r"};
  int answered = 0;
  for (int i = 0; i < 200; ++i) {
    Json file = cell.plan();
    std::vector<Json*> all;
    collect(file, all);
    Json& victim = *all[random() % all.size()];
    victim = victim.is_number() && random() % 2 ? Json(victim.get<double>() * (random() % 100) / 50)
                                                : values[random() % values.size()];
    cell.write("plan.json", file.dump());
    try {
      verifyPlan(cell.root() / "plan.json", cell.root());
      ++answered;
    } catch (const Unreadable&) {
    }
  }
  EXPECT_GT(answered, 15);
}

}  // namespace
}  // namespace handover::verify
