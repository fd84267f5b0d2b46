// SPDX-License-Identifier: Apache-2.0
#include "experiment_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover::ctl {
namespace {

using client::Json;
using testing::HasSubstr;

Json experimentOf(const std::string& cell) {
  return {{"format", "handover-experiment/2"},
          {"cell", cell},
          {"seed", 40},
          {"mode", "all"},
          {"search", "paper"},
          {"objective", "dexterity"},
          {"records", Json::array({{{"index", 2}, {"drawn", Json::object()}}})}};
}

TEST(RepeatCommand, IsOneCommandOfPlainWords) {
  Json record = {{"index", 2}, {"drawn", {{"robots.hubo.base.xyz", {1.25, 0.5, 1.0}}}}};
  record["drawn"]["word"] = "it's; rm";
  EXPECT_EQ(repeatCommand(experimentOf("butler"), record, "serve"),
            "handoverctl plan --cell butler --task serve --mode all --search paper "
            "--objective dexterity --seed 42 --set 'robots.hubo.base.xyz=[1.25, 0.5, 1.0]' "
            "--set 'word=it'\\''s; rm'");
  record["drawn"] = Json::object();
  EXPECT_EQ(repeatCommand(experimentOf("a b"), record, ""),
            "handoverctl plan --cell 'a b' --mode all --search paper --objective dexterity "
            "--seed 42");
}

TEST(ExperimentPage, HoldsTheFileAndWhatIsKnownBeyondIt) {
  PageExtras extras;
  extras.task = "serve";
  extras.daemon_version = "7.8.9";
  extras.runs = {{{{{0.5, 0.0, 1.0}, 0.05}},
                  {{{0.5, 0.0, 0.95}, {0.525, 0.0, 1.0000004}}},
                  "report.failures.html#run-2"}};
  const std::string page = experimentPage(experimentOf("butler"), extras);
  EXPECT_THAT(page, HasSubstr(R"("format": "handover-experiment/2")"));
  EXPECT_THAT(page, HasSubstr(R"("table": "II")"));
  EXPECT_THAT(page, HasSubstr(R"("handoverd": "7.8.9")"));
  EXPECT_THAT(page, HasSubstr(R"("lattice": [[0.5, 0.0, 1.0, 0.05]])"));
  EXPECT_THAT(page, HasSubstr(R"("receiver_tool": [0.525, 0.0, 1.0])"));
  EXPECT_THAT(page, HasSubstr("--task serve"));
  EXPECT_THAT(page, HasSubstr(R"("page": "report.failures.html#run-2")"));
  EXPECT_THAT(experimentPage(experimentOf("elsewhere"), extras), HasSubstr(R"("paper": null)"));
}

TEST(ExperimentPage, AsksForEveryRun) {
  EXPECT_THROW(experimentPage(experimentOf("butler"), {}), std::out_of_range);
}

}  // namespace
}  // namespace handover::ctl
