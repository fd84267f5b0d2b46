// SPDX-License-Identifier: Apache-2.0
#include <handover/common/standard_streams.hpp>

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <iostream>

namespace handover {
namespace {

constexpr int kOutputNotWritable = 3;

/// Open for the other direction: what is read or written fails, as it does while it is closed.
void holdIfClosed(int stream) {
  if (::fcntl(stream, F_GETFD) >= 0) return;
  const int refusing = stream == STDIN_FILENO ? O_WRONLY : O_RDONLY;
  const int held = ::open("/dev/null", refusing);  // the lowest number that is free
  if (held != stream && held >= 0) ::close(held);
}

}  // namespace

void holdStandardStreams() {
  ::signal(SIGPIPE, SIG_IGN);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) holdIfClosed(stream);
}

int checkedOutput(const std::string& program, int code) {
  std::cout.flush();
  if (std::cout || code != 0) return code;
  std::cerr << program << ": cannot write to standard output" << std::endl;
  return kOutputNotWritable;
}

}  // namespace handover
