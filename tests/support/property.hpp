// SPDX-License-Identifier: Apache-2.0
// Properties over generated values (rapidcheck) as GoogleTest assertions, the same values each
// time.
//
// HANDOVER_PROPERTY_CASES=N multiplies the number of cases by N (for long runs);
// HANDOVER_PROPERTY_SEED=S draws others. A failure prints the seed, the shrunk case and why it
// failed.
#pragma once

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

namespace handover::test {

inline std::uint64_t propertyNumber(const char* variable, std::uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

inline std::uint64_t propertySeed() { return propertyNumber("HANDOVER_PROPERTY_SEED", 1); }

inline int propertyCases(int cases) {
  return cases * static_cast<int>(propertyNumber("HANDOVER_PROPERTY_CASES", 1));
}

/// Fails when `property`, a callable over generated arguments that uses RC_ASSERT, does not hold
/// for one of `cases` draws.
template <typename Property>
testing::AssertionResult holds(const std::string& name, int cases, Property&& property) {
  // Else rapidcheck draws, and prints, a seed of its own that nothing here uses.
  ::setenv("RC_PARAMS", ("seed=" + std::to_string(propertySeed())).c_str(), 0);
  rc::detail::TestMetadata metadata;
  metadata.id = metadata.description = name;
  rc::detail::TestParams params;
  params.seed = propertySeed();
  params.maxSuccess = propertyCases(cases);
  const auto result = rc::detail::checkTestable(std::forward<Property>(property), metadata, params);
  if (result.template is<rc::detail::SuccessResult>()) return testing::AssertionSuccess();
  std::ostringstream text;
  rc::detail::printResultMessage(result, text);
  return testing::AssertionFailure()
         << name << ", HANDOVER_PROPERTY_SEED=" << params.seed << ": " << text.str();
}

}  // namespace handover::test
