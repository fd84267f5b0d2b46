// SPDX-License-Identifier: Apache-2.0
// A test with a real daemon in a DDS domain of its own, and the real client programs to ask it.
#pragma once

#include "process.hpp"
#include "temporary_folder.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <memory>
#include <string>
#include <vector>

namespace handover::test {

class ServedCells : public testing::Test {
 protected:
  /// Starts the daemon with cells below a root and waits until it answers, at most `wait` seconds.
  void serve(const std::string& cells, const std::string& root, int threads = 1, int wait = 20) {
    daemon_ = std::make_unique<Process>(
        words(program("handoverd") + " serve " + cells + " --root " + root + " --domain " +
              std::to_string(domain_) + " --threads " + std::to_string(threads)),
        std::vector<std::string>{"XDG_CACHE_HOME=" HANDOVER_BINARY_DIR "/test-cache"});
    ASSERT_EQ(run(ctl("status --wait " + std::to_string(wait)), {}, (wait + 10) * 1s).status, 0)
        << daemon_->err();
  }

  static std::string program(const std::string& name) { return HANDOVER_BINARY_DIR "/bin/" + name; }

  std::vector<std::string> ctl(const std::string& arguments) const {
    return words(program("handoverctl") + " " + arguments + " --domain " + std::to_string(domain_));
  }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  /// handover-verify finds nothing in a plan file of this test.
  void expectValid(const std::string& name, const std::string& more = "") const {
    const Finished verified =
        run(words(program("handover-verify") + " " + file(name) + " " + more), {}, 120s);
    EXPECT_EQ(verified.status, 0) << name << '\n' << verified.out;
  }

  void stop() {
    daemon_->signal(SIGTERM);
    EXPECT_EQ(daemon_->wait(), 0);
  }

  const int domain_ = freeDomain();
  TemporaryFolder folder_;
  std::unique_ptr<Process> daemon_;
};

}  // namespace handover::test
