// SPDX-License-Identifier: Apache-2.0
#include "process.hpp"

#include "sanitized.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace handover::test {
namespace {

using Clock = std::chrono::steady_clock;

// How much longer programs may take than the tests say.
constexpr int kPatience = kSanitized ? 20 : 1;

std::array<int, 2> makePipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  return ends;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (auto& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

/// A datagram socket bound to a loopback port, or -1 when that is taken.
int boundSocket(int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) return fd;
  close(fd);
  return -1;
}

bool portFree(int port) {
  const int fd = boundSocket(port);
  if (fd >= 0) close(fd);
  return fd >= 0;
}

}  // namespace

Process::Process(std::vector<std::string> command, std::vector<std::string> environment) {
  const auto out = makePipe(), err = makePipe();
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (std::string(*entry).rfind("HANDOVER_", 0) != 0) environment.emplace_back(*entry);
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  // A shell has jobs in the background ignore interrupts; the programs shall hear them all the
  // same.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t heard;
  sigemptyset(&heard);
  sigaddset(&heard, SIGINT);
  posix_spawnattr_setsigdefault(&attributes, &heard);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const int failed = posix_spawn(&pid_, command[0].c_str(), &actions, &attributes,
                                 pointers(command).data(), pointers(environment).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(out[1]);
  close(err[1]);
  out_fd_ = out[0];
  err_fd_ = err[0];
  if (failed != 0) throw std::runtime_error(command[0] + ": " + std::strerror(failed));
}

Process::~Process() {
  if (!ended_) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (out_fd_ >= 0) close(out_fd_);
  if (err_fd_ >= 0) close(err_fd_);
}

void Process::signal(int number) const {
  if (!ended_) kill(pid_, number);
}

bool Process::signalChild(int number, std::chrono::milliseconds most) const {
  const std::string pid = std::to_string(pid_);
  const auto until = std::chrono::steady_clock::now() + most;
  while (std::chrono::steady_clock::now() < until) {
    std::ifstream children("/proc/" + pid + "/task/" + pid + "/children");
    if (pid_t child = 0; children >> child) return ::kill(child, number) == 0;
    std::this_thread::sleep_for(1ms);  // of one look to the next
  }
  return false;
}

void Process::closeOutput() {
  for (int* end : {&out_fd_, &err_fd_}) {
    close(*end);
    *end = -1;
  }
}

bool Process::waitUntilBlocks(int number, std::chrono::milliseconds most) const {
  const std::filesystem::path file = "/proc/" + std::to_string(pid_) + "/status";
  const auto until = Clock::now() + kPatience * most;
  while (Clock::now() < until) {
    const std::string status = textOf(file);
    const auto at = status.find("SigBlk:");
    if (at == std::string::npos) return false;
    const auto blocked = std::stoull(status.substr(at + 7), nullptr, 16);
    if ((blocked >> (number - 1) & 1u) != 0) return true;
  }
  return false;
}

/// Reads what comes next; false when both pipes are closed or the time is over.
bool Process::readSome(Clock::time_point until) {
  std::array<pollfd, 2> polled{pollfd{out_fd_, POLLIN, 0}, pollfd{err_fd_, POLLIN, 0}};
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
  if ((out_fd_ < 0 && err_fd_ < 0) || left <= 0) return false;
  if (poll(polled.data(), polled.size(), static_cast<int>(left)) <= 0) return errno == EINTR;
  for (auto* end : {&out_fd_, &err_fd_}) {
    const pollfd& state = polled[end == &out_fd_ ? 0 : 1];
    if (*end < 0 || (state.revents & (POLLIN | POLLHUP)) == 0) continue;
    char buffer[65536];
    const ssize_t got = read(*end, buffer, sizeof(buffer));
    if (got > 0) {
      (end == &out_fd_ ? out_ : err_).append(buffer, static_cast<std::size_t>(got));
    } else {
      close(*end);
      *end = -1;
    }
  }
  return true;
}

bool Process::waitForOutput(const std::string& text, std::chrono::milliseconds most) {
  const auto until = Clock::now() + kPatience * most;
  const auto seen = [&] {
    return out_.find(text) != std::string::npos || err_.find(text) != std::string::npos;
  };
  while (!seen()) {
    if (!readSome(until)) return seen();
  }
  return true;
}

std::optional<int> Process::wait(std::chrono::milliseconds most) {
  const auto until = Clock::now() + kPatience * most;
  while (readSome(until)) {
  }
  if (out_fd_ >= 0 || err_fd_ >= 0) return std::nullopt;  // it still holds its output
  int status = 0;
  if (waitpid(pid_, &status, 0) != pid_) return std::nullopt;
  ended_ = true;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Finished run(std::vector<std::string> command, std::vector<std::string> environment,
             std::chrono::milliseconds most) {
  std::string text;
  for (const auto& word : command) text += word + " ";
  Process process(std::move(command), std::move(environment));
  const auto status = process.wait(most);
  if (!status) throw std::runtime_error("took too long: " + text + process.err());
  return {*status, process.out(), process.err()};
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

std::string textOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

int freeDomain() {
  static int next = static_cast<int>(getpid()) % 89;
  for (int tries = 0; tries < 89; ++tries) {
    next = (next + 1) % 89;
    const int domain = 10 + next;
    // Of the domain's 250 ports participants use those from 10 on. The one held until we end keeps
    // other tests out before anybody has joined.
    const int base = 7400 + 250 * domain;
    if (!portFree(base + 10) || !portFree(base + 12)) continue;
    if (boundSocket(base + 5) >= 0) return domain;
  }
  throw std::runtime_error("no free domain");
}

}  // namespace handover::test
