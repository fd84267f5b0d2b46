// SPDX-License-Identifier: Apache-2.0
#include <handover/common/atomic_file.hpp>
#include <handover/common/descriptor.hpp>
#include <handover/common/request_id.hpp>

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>

#include <system_error>

namespace handover {
namespace {

namespace fs = std::filesystem;

std::string reason(int error) { return std::generic_category().message(error); }

bool writeAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// Signals that would end this thread's process wait as long as it lives: what is half written is
/// taken away first.
class SignalsWait {
 public:
  SignalsWait() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }

  ~SignalsWait() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

  SignalsWait(const SignalsWait&) = delete;
  SignalsWait& operator=(const SignalsWait&) = delete;

 private:
  sigset_t before_;
};

/// A new file beside `file`, by a name that nobody can know before.
int openBeside(const fs::path& file, std::string& name) {
  name = file.string() + "." + RequestId::random().hex().substr(0, 8);
  return ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

/// Makes the new name last through a loss of power.
void syncFolder(const fs::path& folder) {
  const Descriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() >= 0) ::fsync(fd.get());
}

}  // namespace

Result<void> writeFileAtomically(const fs::path& file, std::span<const std::byte> bytes) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code trouble;
  fs::create_directories(folder, trouble);
  if (trouble) return Error{ErrorCode::kIo, folder.string() + ": " + trouble.message()};

  const SignalsWait wait;
  std::string temporary;
  Descriptor fd(openBeside(file, temporary));
  if (fd.get() < 0) return Error{ErrorCode::kIo, temporary + ": " + reason(errno)};
  const auto fail = [&](int error) {
    ::unlink(temporary.c_str());
    return Error{ErrorCode::kIo, file.string() + ": " + reason(error)};
  };
  if (!writeAll(fd.get(), bytes) || ::fsync(fd.get()) != 0) return fail(errno);
  if (const int error = fd.close(); error != 0) return fail(error);
  if (::rename(temporary.c_str(), file.c_str()) != 0) return fail(errno);
  syncFolder(folder);
  return {};
}

Result<void> canWriteBeside(const fs::path& file) {
  const SignalsWait wait;
  std::string temporary;
  const Descriptor fd(openBeside(file, temporary));
  if (fd.get() < 0) return Error{ErrorCode::kIo, file.string() + ": " + reason(errno)};
  ::unlink(temporary.c_str());
  return {};
}

}  // namespace handover
