// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/apart.hpp"

#include <handover/common/descriptor.hpp>

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace handover {
namespace {

/// The largest mesh that may be read takes some seconds.
constexpr rlim_t kMostCpuSeconds = 60;
/// Beyond what this process has; a mesh of 64 MiB takes some hundred.
constexpr rlim_t kMostMib = 4096;

// What an answer of the child's begins with, before its length.
constexpr char kResult = 'r', kThrown = 't';

rlim_t dataBytes() {
  std::ifstream statm("/proc/self/statm");
  rlim_t size = 0, resident = 0, shared = 0, text = 0, library = 0, data = 0;
  statm >> size >> resident >> shared >> text >> library >> data;
  return data * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void limit(__rlimit_resource resource, rlim_t most) {
  const rlimit both{most, most};
  (void)::setrlimit(resource, &both);  // a lower one stays
}

/// What kills goes to nobody's handler, and leaves no core file of the whole process behind.
void confine(rlim_t data_before) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGPIPE}) {
    (void)::signal(signal, SIG_DFL);
  }
  sigset_t none;
  sigemptyset(&none);
  (void)::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_DATA, data_before + (kMostMib << 20));
}

/// A minute from now on.
void boundTime() {
  rusage used{};
  rlimit cpu{};
  if (::getrusage(RUSAGE_SELF, &used) != 0 || ::getrlimit(RLIMIT_CPU, &cpu) != 0) return;
  const auto seconds = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  cpu.rlim_cur = std::min(cpu.rlim_max, seconds + 1 + kMostCpuSeconds);
  (void)::setrlimit(RLIMIT_CPU, &cpu);
}

/// False: the other end is gone. A socket, so that nobody gets SIGPIPE.
bool sendAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool receiveAll(int fd, char* to, std::size_t size) {
  while (size > 0) {
    const ssize_t got = ::recv(fd, to, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

bool sendText(int fd, std::string_view text) {
  const std::uint64_t size = text.size();
  return sendAll(fd, {reinterpret_cast<const char*>(&size), sizeof(size)}) && sendAll(fd, text);
}

/// nullopt: the other end is gone, or says what cannot be.
std::optional<std::string> receiveText(int fd) {
  std::uint64_t size = 0;
  if (!receiveAll(fd, reinterpret_cast<char*>(&size), sizeof(size))) return std::nullopt;
  if (size > kMostMib << 20) return std::nullopt;
  std::string text(size, '\0');
  if (!receiveAll(fd, text.data(), text.size())) return std::nullopt;
  return text;
}

/// What `work` makes of a text, or what it throws, after its mark.
std::string answerTo(const std::string& given, const Apart::Work& work) {
  try {
    return kResult + work(given);
  } catch (const std::bad_alloc&) {
    return kThrown + ("needs more than " + std::to_string(kMostMib >> 10) + " GiB");
  } catch (const std::exception& error) {
    return kThrown + std::string(error.what());
  }
}

[[noreturn]] void beChild(int peer, const Apart::Work& work) noexcept {
  while (const auto given = receiveText(peer)) {
    boundTime();
    if (!sendText(peer, answerTo(*given, work))) break;
  }
  ::_exit(0);
}

/// Waits for the child; how it ended.
std::string endOf(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return "ended early";
  }
  if (!WIFSIGNALED(status)) return "ended early";
  if (WTERMSIG(status) == SIGXCPU) {
    return "takes more than " + std::to_string(kMostCpuSeconds) + " s";
  }
  return std::string("crashed: ") + ::strsignal(WTERMSIG(status));
}

}  // namespace

struct Apart::Child {
  pid_t id = -1;
  Descriptor peer{-1};

  Child(pid_t process, int fd) : id(process), peer(fd) {}

  ~Child() {
    peer.close();  // it ends by itself
    if (id > 0) (void)endOf(id);
  }

  std::string ended() {
    peer.close();
    return endOf(std::exchange(id, -1));
  }
};

Apart::Apart(Work work) : work_(std::move(work)) {}

Apart::~Apart() = default;

std::unique_ptr<Apart::Child> Apart::makeChild() const {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return nullptr;
  auto child = std::make_unique<Child>(-1, ends[0]);
  const Descriptor its(ends[1]);
  const rlim_t data_before = dataBytes();
  child->id = ::fork();
  if (child->id < 0) return nullptr;
  if (child->id > 0) return child;
  child->peer.close();
  confine(data_before);
  beChild(its.get(), work_);
}

Result<std::string> Apart::operator()(const std::string& given) {
  if (!child_) child_ = makeChild();
  if (!child_) {
    return Error{ErrorCode::kIo, "no process: " + std::generic_category().message(errno)};
  }
  std::optional<std::string> answer;
  if (sendText(child_->peer.get(), given)) answer = receiveText(child_->peer.get());
  if (!answer || answer->empty()) {
    const std::string end = child_->ended();
    child_.reset();
    return Error{ErrorCode::kInvalidInput, end};
  }
  const bool thrown = answer->front() == kThrown;
  answer->erase(0, 1);
  if (thrown) return Error{ErrorCode::kInvalidInput, std::move(*answer)};
  return std::move(*answer);
}

}  // namespace handover
