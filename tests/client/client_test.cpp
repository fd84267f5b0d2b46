// SPDX-License-Identifier: Apache-2.0
#include <handover/client/client.hpp>

#include <gtest/gtest.h>

#include <cstdlib>

namespace handover::client {
namespace {

TEST(Client, RefusesADomainOfTheEnvironmentThatIsNone) {
  for (const char* domain : {"x", "233", "-1", "1 "}) {
    setenv("HANDOVER_DOMAIN", domain, 1);
    EXPECT_THROW(Client(), std::invalid_argument) << domain;
  }
  unsetenv("HANDOVER_DOMAIN");
}

}  // namespace
}  // namespace handover::client
