// SPDX-License-Identifier: Apache-2.0
#include <handover/common/log.hpp>
#include <handover/common/printable.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handover {
namespace {

TEST(Printable, KeepsTextAndEscapesWhatControlsOrIsNone) {
  EXPECT_EQ(printable("robots.hubo: 5\xC2\xB5m, \xE2\x82\xAC, \xF0\x9F\xA4\x96"),
            "robots.hubo: 5\xC2\xB5m, \xE2\x82\xAC, \xF0\x9F\xA4\x96");
  EXPECT_EQ(printable("a\nb\tc\x1B[2J\x7F"), "a\\nb\\x09c\\x1b[2J\\x7f");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\xc2\\x9b31m");  // a control sequence of one character
  EXPECT_EQ(printable("\x9B\xFF\xC0\x80"), "\\x9b\\xff\\xc0\\x80");
  EXPECT_EQ(printable("cut \xE2\x82"), "cut \\xe2\\x82");
}

TEST(Log, ALineIsOneLineInUniversalTimeWhateverItsText) {
  testing::internal::CaptureStderr();
  logger("tests")->info("of {}: done", "me\n2026-01-01 all robots released");
  const std::string line = testing::internal::GetCapturedStderr();
  EXPECT_THAT(line, testing::MatchesRegex("....-..-..T..:..:..\\....Z .tests. .info. of "
                                          "me.n2026-01-01 all robots released: done\n"));
}

TEST(Log, AnEntryOfTheJournalHasAFieldALine) {
  EXPECT_EQ(journalEntry("runtime", spdlog::level::warn, "a\nPRIORITY=0",
                         {{"HANDOVER_CELL", "butler\nMESSAGE=b"}}),
            "MESSAGE=[runtime] a\\nPRIORITY=0\nPRIORITY=4\nSYSLOG_IDENTIFIER=common_test\n"
            "HANDOVER_MODULE=runtime\nHANDOVER_CELL=butler\\nMESSAGE=b\n");
}

}  // namespace
}  // namespace handover
