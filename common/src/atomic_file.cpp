// SPDX-License-Identifier: Apache-2.0
#include <handover/common/atomic_file.hpp>
#include <handover/common/descriptor.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <cstdlib>
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

  std::string temporary = file.string() + ".XXXXXX";
  Descriptor fd(::mkostemp(temporary.data(), O_CLOEXEC));
  if (fd.get() < 0) return Error{ErrorCode::kIo, temporary + ": " + reason(errno)};
  const auto fail = [&](int error) {
    ::unlink(temporary.c_str());
    return Error{ErrorCode::kIo, file.string() + ": " + reason(error)};
  };
  if (::fchmod(fd.get(), 0644) != 0 || !writeAll(fd.get(), bytes) || ::fsync(fd.get()) != 0) {
    return fail(errno);
  }
  if (const int error = fd.close(); error != 0) return fail(error);
  if (::rename(temporary.c_str(), file.c_str()) != 0) return fail(errno);
  syncFolder(folder);
  return {};
}

}  // namespace handover
