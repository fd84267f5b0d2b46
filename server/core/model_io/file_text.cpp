// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/file_text.hpp"

#include <handover/common/utf8.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace handover {
namespace {

constexpr std::size_t kMostShown = 300;

Error unreadable(int error) {
  if (error == ENOENT || error == ENOTDIR) return {ErrorCode::kNotFound, "no such file"};
  return {ErrorCode::kIo, "cannot be read: " + std::generic_category().message(error)};
}

/// What a file is that is not plain; nullptr for a plain one.
const char* oddKind(mode_t mode) {
  if (S_ISREG(mode)) return nullptr;
  if (S_ISDIR(mode)) return "is a folder, not a file";
  if (S_ISFIFO(mode)) return "is a pipe, not a plain file";
  if (S_ISSOCK(mode)) return "is a socket, not a plain file";
  return "is a device, not a plain file";
}

class Descriptor {
 public:
  explicit Descriptor(const std::filesystem::path& file)
      : fd_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {}

  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }

  int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

Result<std::string> readFileText(const std::filesystem::path& file, std::uint64_t most_mib) {
  struct stat status {};

  // Before opening: to open a device may do something.
  if (::stat(file.c_str(), &status) != 0) return unreadable(errno);
  if (const char* odd = oddKind(status.st_mode)) return {ErrorCode::kInvalidInput, odd};
  const Descriptor fd(file);
  if (fd.get() < 0 || ::fstat(fd.get(), &status) != 0) return unreadable(errno);
  if (const char* odd = oddKind(status.st_mode)) return {ErrorCode::kInvalidInput, odd};

  const std::uint64_t most = most_mib << 20;
  const Error too_large{ErrorCode::kInvalidInput,
                        "is larger than " + std::to_string(most_mib) + " MiB"};
  if (static_cast<std::uint64_t>(status.st_size) > most) return too_large;
  std::string text(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t filled = 0;
  while (true) {  // a file may grow, and those of /proc say that they are empty
    if (filled == text.size()) text.resize(filled + 4096);
    const ssize_t got = ::read(fd.get(), text.data() + filled, text.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return unreadable(errno);
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
    if (filled > most) return too_large;
  }
  text.resize(filled);
  return text;
}

int lineOfBadText(std::string_view text) {
  int line = 1;
  for (std::size_t at = 0; at < text.size();) {
    line += text[at] == '\n';
    const std::size_t size = text[at] == '\0' ? 0 : characterSize(text.substr(at));
    if (size == 0) return line;
    at += size;
  }
  return 0;
}

std::string oneLine(std::string text) {
  if (text.size() > kMostShown) {
    std::size_t end = kMostShown;  // not within a character of several bytes
    while (end > 0 && goesOn(text[end])) --end;
    text.resize(end);
    text += "...";
  }
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

}  // namespace handover
