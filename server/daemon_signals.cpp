// SPDX-License-Identifier: Apache-2.0
#include "daemon_signals.hpp"

#include "runtime/thread_name.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <string_view>

namespace handover {
namespace {

constexpr std::uint64_t bitOf(int signal) { return std::uint64_t{1} << (signal - 1); }

/// Runs before libraries are started, which takes most of the time until main(): a stop signal of
/// that time waits too. A plain system call, since not even a sanitizer is started yet.
__attribute__((no_sanitize("address", "thread", "undefined"))) void holdSignals(int, char**,
                                                                                char**) {
  const std::uint64_t set = bitOf(SIGTERM) | bitOf(SIGINT) | bitOf(SIGHUP);
  ::syscall(SYS_rt_sigprocmask, SIG_BLOCK, &set, nullptr, sizeof(set));
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const kHoldSignals)(int, char**,
                                                                         char**) = holdSignals;

sigset_t daemonSignalSet() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGUSR2}) sigaddset(&set, signal);
  return set;
}

std::atomic<int> exit_of_hang = 0;
static_assert(std::atomic<int>::is_always_lock_free);  // read in a handler

/// The time for stopping is over.
void endNow(int) {
  constexpr std::string_view text = "handoverd: the stop hangs and is cut short\n";
  [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, text.data(), text.size());
  ::_exit(exit_of_hang);
}

void limitStop() {
  struct sigaction action {};

  action.sa_handler = endNow;
  sigaction(SIGALRM, &action, nullptr);
  sigset_t alarm_only;
  sigemptyset(&alarm_only);
  sigaddset(&alarm_only, SIGALRM);
  pthread_sigmask(SIG_UNBLOCK, &alarm_only, nullptr);
  ::alarm(DaemonSignals::kLongestStop);
}

}  // namespace

void DaemonSignals::leaveThem() {
  const sigset_t set = daemonSignalSet();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void DaemonSignals::setExitOfHang(int code) { exit_of_hang = code; }

DaemonSignals::DaemonSignals() : set_(daemonSignalSet()) {
  pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  ::signal(SIGALRM, SIG_IGN);
  thread_ = std::jthread([this] { loop(); });
}

DaemonSignals::~DaemonSignals() {
  ending_ = true;
  pthread_kill(thread_.native_handle(), SIGUSR1);
}

int DaemonSignals::wait() {
  MutexLock lock(mutex_);
  came_.wait(lock, [this]() HANDOVER_REQUIRES(mutex_) { return !signals_.empty(); });
  const int signal = signals_.front();
  signals_.pop_front();
  return signal;
}

void DaemonSignals::loop() noexcept {
  nameThread("signals");
  while (true) {
    int signal = 0;
    sigwait(&set_, &signal);
    if (ending_) return;
    if (signal == SIGUSR1 || signal == SIGUSR2) continue;
    if (signal != SIGHUP && !stopping_.over()) {
      stopping_.cancel();
      limitStop();
    }
    {
      const MutexLock lock(mutex_);
      signals_.push_back(signal);
    }
    came_.notify_all();
  }
}

}  // namespace handover
