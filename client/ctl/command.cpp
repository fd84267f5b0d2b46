// SPDX-License-Identifier: Apache-2.0
#include "command.hpp"

#include "plan_file/json_writer.hpp"

#include <iostream>

namespace handover::ctl {

using client::ClientError;

std::ostream& people(const CommonOptions& common) { return common.json ? std::cerr : std::cout; }

int fail(const CommonOptions& common, int code, const std::string& text) {
  std::cerr << "handoverctl: " << text << std::endl;
  if (common.json) {
    std::cout << client::compact(
                     client::Json{{"type", "error"}, {"exit_code", code}, {"text", text}})
              << std::endl;
  }
  return code;
}

int exitCodeOf(ClientError::Code code) {
  switch (code) {
    case ClientError::Code::kNoDaemon:
    case ClientError::Code::kDaemonLost:
    case ClientError::Code::kTimeLimit:
      return kExitNoDaemon;
    case ClientError::Code::kInterrupted:
      return kExitCancelled;
    case ClientError::Code::kBadStream:
      return kExitInternal;
    case ClientError::Code::kDds:
      return kExitDds;
  }
  return kExitInternal;
}

}  // namespace handover::ctl
