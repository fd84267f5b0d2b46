// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace handover::ctl {

/// Nothing is said about a plan since it, or a file that it names, cannot be read.
class UnreadablePlan : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The program handover-verify that stands beside this one.
class VerifyProgram {
 public:
  /// @throws std::runtime_error when it is not there.
  VerifyProgram();

  /// What it finds wrong with a plan file, a line each; none: the plan is valid.
  /// @param root of the paths in the plan; empty: its own rule.
  /// @throws UnreadablePlan when it cannot read the plan or a file that it names;
  /// std::runtime_error when it cannot be run or does not end by itself.
  std::vector<std::string> violations(const std::filesystem::path& plan,
                                      const std::string& root) const;

 private:
  std::filesystem::path program_;
};

}  // namespace handover::ctl
