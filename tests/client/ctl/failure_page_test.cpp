// SPDX-License-Identifier: Apache-2.0
#include "failure_page.hpp"

#include "sample_plan.hpp"

#include <handover/client/plan_file.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover::ctl {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using view::test::SampleCell;

TEST(FailurePage, LiesBesideTheReportAndIsLinkedByRun) {
  const SampleCell cell;
  FailurePage page(cell.root() / "my report.html");
  EXPECT_EQ(page.path(), cell.root() / "my report.failures.html");
  EXPECT_EQ(page.linkTo(7), "");
  page.add(7, cell.failure().dump());
  EXPECT_EQ(page.linkTo(7), "my%20report.failures.html#run-7");
  ASSERT_TRUE(page.write(cell.root()));
  const std::string text = client::readPlanText(page.path());
  EXPECT_THAT(text, HasSubstr(R"({"name":"run-7","file":{)"));
  EXPECT_THAT(text, HasSubstr("At none of 412 poses"));
}

TEST(FailurePage, IsNotThereWithoutFailures) {
  const SampleCell cell;
  cell.write("e.failures.html", "of another experiment");
  EXPECT_TRUE(FailurePage(cell.root() / "e.html").write(cell.root()));
  EXPECT_FALSE(fs::exists(cell.root() / "e.failures.html"));
}

TEST(FailurePage, KeepsTheFirstRunsWhicheverComeFirst) {
  const SampleCell cell;
  FailurePage page(cell.root() / "e.html");
  for (std::uint64_t run = 2 * FailurePage::kMost; run-- > 0;) page.add(run, "{}");
  EXPECT_NE(page.linkTo(0), "");
  EXPECT_NE(page.linkTo(FailurePage::kMost - 1), "");
  EXPECT_EQ(page.linkTo(FailurePage::kMost), "");
}

TEST(FailurePage, SaysWhatItCannotReadAndWhereItCannotWrite) {
  const SampleCell cell;
  FailurePage page(cell.root() / "e.html");
  page.add(1, cell.failure().dump());
  EXPECT_THROW((void)page.write("/nonexistent"), client::PlanFileError);
  EXPECT_FALSE(fs::exists(page.path()));
  FailurePage nowhere(cell.root() / "none" / "e.html");
  nowhere.add(1, cell.failure().dump());
  EXPECT_FALSE(nowhere.write(cell.root()));
}

}  // namespace
}  // namespace handover::ctl
