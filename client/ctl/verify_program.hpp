// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace handover::ctl {

/// The program handover-verify that stands beside this one.
class VerifyProgram {
 public:
  /// @throws std::runtime_error when it is not there.
  VerifyProgram();

  /// What it finds wrong with a plan file, a line each; none: the plan is valid.
  /// @throws std::runtime_error when it cannot be run or does not end by itself.
  std::vector<std::string> violations(const std::filesystem::path& plan) const;

 private:
  std::filesystem::path program_;
};

}  // namespace handover::ctl
