// SPDX-License-Identifier: Apache-2.0
#include "verify_program.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <sstream>
#include <stdexcept>

namespace handover::ctl {
namespace {

namespace fs = std::filesystem;

constexpr int kValid = 0, kInvalid = 1, kUnreadable = 2;  // what the program returns

/// Everything that comes until the other end is closed.
std::string readAll(int fd) {
  std::string text;
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t got = read(fd, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(got));
  }
}

}  // namespace

VerifyProgram::VerifyProgram() {
  std::error_code error;
  program_ = fs::read_symlink("/proc/self/exe", error).parent_path() / "handover-verify";
  if (access(program_.c_str(), X_OK) != 0) {
    throw std::runtime_error("no program " + program_.string());
  }
}

std::vector<std::string> VerifyProgram::violations(const fs::path& plan,
                                                   const std::string& root) const {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  posix_spawnattr_t attributes;  // signals that we wait for are not blocked in it
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  std::string program = program_.string(), file = fs::absolute(plan).string();
  std::string flag = "--root", folder = root;
  std::vector<char*> arguments{program.data(), file.data()};
  if (!root.empty()) arguments.insert(arguments.end(), {flag.data(), folder.data()});
  arguments.push_back(nullptr);
  pid_t pid = -1;
  const int failed =
      posix_spawn(&pid, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  const std::string text = failed == 0 ? readAll(ends[0]) : std::string();
  close(ends[0]);
  if (failed != 0) throw std::runtime_error("cannot run " + program);

  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code != kValid && code != kInvalid && code != kUnreadable) {
    throw std::runtime_error(program + " broke off: " + text);
  }
  if (code == kUnreadable) throw UnreadablePlan(text);
  std::vector<std::string> lines;
  if (code == kValid) return lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  if (lines.size() > 1) lines.pop_back();  // it only counts the others
  if (lines.empty()) lines.emplace_back("invalid");
  return lines;
}

}  // namespace handover::ctl
