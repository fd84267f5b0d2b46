// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <functional>
#include <thread>

namespace handover::ctl {

/// Calls `on_signal` from its own thread at the first SIGINT, SIGTERM or SIGHUP and ends the
/// process at the second. A SIGHUP that is ignored, as nohup has it, stays so.
/// @pre the signals are blocked in every thread (blockSignals() before the first one).
class SignalWatch {
 public:
  SignalWatch(std::function<void()> on_signal, int second_exit_code)
      : thread_([on_signal = std::move(on_signal), second_exit_code] {
          bool again = false;
          while (true) {
            const sigset_t set = signals();
            int signal = 0;
            if (sigwait(&set, &signal) != 0 || signal == SIGUSR1) return;
            if (again) _exit(second_exit_code);
            again = true;
            on_signal();
          }
        }) {}

  ~SignalWatch() { pthread_kill(thread_.native_handle(), SIGUSR1); }

  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  static void blockSignals() {
    const sigset_t set = signals();
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
  }

 private:
  static sigset_t signals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGUSR1);

    struct sigaction hangup {};

    sigaction(SIGHUP, nullptr, &hangup);
    if (hangup.sa_handler != SIG_IGN) sigaddset(&set, SIGHUP);
    return set;
  }

  std::jthread thread_;
};

}  // namespace handover::ctl
