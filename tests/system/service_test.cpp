// SPDX-License-Identifier: Apache-2.0
// What the daemon tells systemd.
#include "process.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace handover::test {
namespace {

/// systemd's end of NOTIFY_SOCKET, in the abstract space.
class NotifySocket {
 public:
  NotifySocket() : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socklen_t size = sizeof(sa_family_t);  // the kernel finds a name
    ::bind(fd_, reinterpret_cast<sockaddr*>(&address), size);
    size = sizeof(address);
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    name_ = "@" + std::string(address.sun_path + 1, size - sizeof(sa_family_t) - 1);
    const timeval patience{20, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  }

  ~NotifySocket() { ::close(fd_); }

  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  const std::string& name() const { return name_; }

  /// The next word that is not `skipped`; empty when none comes.
  std::string next(const std::string& skipped = "") const {
    while (true) {
      char word[256];
      const ssize_t size = ::recv(fd_, word, sizeof(word), 0);
      if (size <= 0) return "";
      const std::string text(word, static_cast<std::size_t>(size));
      if (text != skipped) return text;
    }
  }

 private:
  int fd_;
  std::string name_;
};

TEST(Service, TellsThatItIsReadyThatItLivesAndThatItStops) {
  const NotifySocket systemd;
  Process daemon({HANDOVER_BINARY_DIR "/tests/scripted_daemon", std::to_string(freeDomain())},
                 {"NOTIFY_SOCKET=" + systemd.name()});
  EXPECT_EQ(systemd.next("WATCHDOG=1"), "READY=1");
  EXPECT_EQ(systemd.next(), "WATCHDOG=1");
  daemon.signal(SIGTERM);
  EXPECT_EQ(systemd.next("WATCHDOG=1"), "STOPPING=1");
  EXPECT_EQ(daemon.wait(5s), 0);
}

}  // namespace
}  // namespace handover::test
