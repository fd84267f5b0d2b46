// SPDX-License-Identifier: Apache-2.0
// Programs started, watched and ended by system tests.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace handover::test {

using namespace std::chrono_literals;

/// A child process with its output read through pipes. The destructor kills what still runs.
class Process {
 public:
  /// `environment`: NAME=VALUE on top of ours. @throws std::runtime_error.
  explicit Process(std::vector<std::string> command, std::vector<std::string> environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const;
  /// As signal(), to a child process of the program, once it has one; false after `most`.
  bool signalChild(int number, std::chrono::milliseconds most = 20s) const;
  /// As readers that are gone: what the program writes from now on has no taker.
  void closeOutput();
  /// Waits until the program blocks a signal, from outside, as the system tells.
  bool waitUntilBlocks(int number, std::chrono::milliseconds most = 20s) const;
  /// Waits until standard output (or error) holds the text; false at its end or after `most`.
  bool waitForOutput(const std::string& text, std::chrono::milliseconds most = 20s);
  /// Waits for the end: the exit status, 128 + n for a signal; nullopt after `most`.
  std::optional<int> wait(std::chrono::milliseconds most = 30s);

  const std::string& out() const { return out_; }

  const std::string& err() const { return err_; }

 private:
  bool readSome(std::chrono::steady_clock::time_point until);

  pid_t pid_ = -1;
  int out_fd_ = -1, err_fd_ = -1;
  std::string out_, err_;
  bool ended_ = false;
};

/// What a finished program left behind.
struct Finished {
  int status = -1;
  std::string out, err;
};

/// Runs a program to its end. @throws std::runtime_error when it takes longer than `most`.
Finished run(std::vector<std::string> command, std::vector<std::string> environment = {},
             std::chrono::milliseconds most = 30s);

/// Split at blanks.
std::vector<std::string> words(const std::string& text);

/// A file's content; empty when it cannot be read.
std::string textOf(const std::filesystem::path& file);

/// A DDS domain that nobody on this machine uses, ours until this process ends; a different one at
/// each call.
int freeDomain();

}  // namespace handover::test
