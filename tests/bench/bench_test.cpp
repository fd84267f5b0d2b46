// SPDX-License-Identifier: Apache-2.0
// The bench runs, and its file has the promised shape.
#include "process.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <set>

namespace handover::test {
namespace {

TEST(Bench, WritesItsRowsAndShowsThem) {
  const TemporaryFolder folder;
  const std::string file = folder / "bench.json";
  const Finished bench =
      run({HANDOVER_BINARY_DIR "/bin/handover-bench", "--smoke", "--output", file},
          {"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"}, 280s);
  ASSERT_EQ(bench.status, 0) << bench.out << bench.err;
  const auto rows = nlohmann::json::parse(textOf(file));
  ASSERT_TRUE(rows.is_array());
  std::set<std::string> units, names;
  for (const auto& row : rows) {
    std::set<std::string> keys;
    for (const auto& [key, value] : row.items()) keys.insert(key);
    EXPECT_EQ(keys, (std::set<std::string>{"name", "ours", "reference", "reference_name", "ratio",
                                           "unit"}));
    const double ours = row.at("ours"), reference = row.at("reference");
    EXPECT_GT(ours, 0) << row;
    EXPECT_GT(reference, 0) << row;
    EXPECT_DOUBLE_EQ(row.at("ratio"), reference / ours);
    EXPECT_THAT(bench.out, testing::HasSubstr(row.at("name").get<std::string>()));
    EXPECT_THAT(bench.out, testing::HasSubstr(row.at("reference_name").get<std::string>()));
    units.insert(row.at("unit"));
    names.insert(row.at("name"));
  }
  EXPECT_EQ(names.size(), 20u);
  EXPECT_EQ(units, (std::set<std::string>{"%", "ns", "s", "us"}));
}

}  // namespace
}  // namespace handover::test
