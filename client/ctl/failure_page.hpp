// SPDX-License-Identifier: Apache-2.0
// The page of an experiment's failed runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace handover::ctl {

/// Gathers plan files of failed runs for one page that shows them one at a time.
class FailurePage {
 public:
  /// Runs that it shows at most, those of the lowest indices: it stays some megabytes long.
  static constexpr std::size_t kMost = 50;

  /// @param report  the experiment's page, beside which it lies: report.failures.html.
  explicit FailurePage(const std::filesystem::path& report);

  const std::filesystem::path& path() const { return path_; }

  /// @param plan_text  a plan file without a plan, but with a scene.
  void add(std::uint64_t run, std::string plan_text);

  /// Writes the page; without any run there is none afterwards, not even an older one.
  /// @param root  that the plan files' paths are relative to; empty: found.
  /// @return false when the file cannot be written.
  /// @throws client::PlanFileError when something that a plan file names cannot be read.
  bool write(const std::filesystem::path& root) const;

  /// The address of a run in it, relative to the report; empty: it is not in it.
  std::string linkTo(std::uint64_t run) const;

 private:
  std::filesystem::path path_;
  std::map<std::uint64_t, std::string> runs_;
};

}  // namespace handover::ctl
