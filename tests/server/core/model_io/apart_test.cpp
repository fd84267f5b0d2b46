// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/apart.hpp"

#include "support/sanitized.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <unistd.h>

#include <memory>
#include <stdexcept>
#include <vector>

namespace handover {
namespace {

using ::testing::HasSubstr;

Result<std::string> once(const std::function<std::string()>& work) {
  return Apart([&](const std::string&) { return work(); })("");
}

std::string failureOf(const std::function<std::string()>& work) {
  const auto result = once(work);
  return result ? "none" : result.error().detail;
}

TEST(Apart, GivesWhatTheWorkReturned) {
  EXPECT_EQ(*once([] { return std::string("\0r", 2); }), std::string("\0r", 2));
  EXPECT_EQ(*once([] { return std::string(); }), "");
  const std::string large(10'000'000, 'x');  // more than a pipe holds
  EXPECT_EQ(*once([&] { return large; }), large);
}

TEST(Apart, ChangesNothingHere) {
  int value = 1;
  ASSERT_TRUE(once([&] {
    value = 2;
    return std::string();
  }));
  EXPECT_EQ(value, 1);
}

TEST(Apart, SaysWhatWasThrown) {
  EXPECT_EQ(failureOf([]() -> std::string { throw std::runtime_error("is odd"); }), "is odd");
}

TEST(Apart, OutlivesACrash) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGKILL, SIGFPE}) {
    EXPECT_THAT(failureOf([signal] {
                  (void)raise(signal);
                  return std::string("went on");
                }),
                HasSubstr("crashed: "));
  }
  EXPECT_EQ(failureOf([]() -> std::string { _exit(0); }), "ended early");
}

TEST(Apart, CrashesThoughTheSignalIsBlockedHere) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  EXPECT_THAT(failureOf([] {
                (void)raise(SIGABRT);
                return std::string("went on");
              }),
              HasSubstr("crashed: "));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

TEST(Apart, GoesOnAfterACrash) {
  Apart doubled([](const std::string& given) {
    if (given == "bad") abort();
    return given + given;
  });
  EXPECT_EQ(*doubled("ab"), "abab");
  EXPECT_THAT(doubled("bad").error().detail, HasSubstr("crashed: "));
  EXPECT_EQ(*doubled("cd"), "cdcd");
}

TEST(Apart, BoundsMemory) {
  if (test::kSanitized) GTEST_SKIP() << "sanitizers end the child themselves";
  EXPECT_EQ(failureOf([] {
              std::vector<std::unique_ptr<char[]>> all;
              while (true) all.emplace_back(new char[std::size_t{1} << 30]);
              return std::string();
            }),
            "needs more than 4 GiB");
}

}  // namespace
}  // namespace handover
