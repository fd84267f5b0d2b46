// SPDX-License-Identifier: Apache-2.0
// The files that a plan names.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace handover::view {

/// Where a plan's paths are looked up unless --root says otherwise: HANDOVER_ROOT, else the
/// installed share beside the running program, else the repository that it was built in. Empty:
/// none of them is there.
std::filesystem::path defaultRoot();

class RootFiles {
 public:
  explicit RootFiles(std::filesystem::path root) : root_(std::move(root)) {}

  std::filesystem::path pathOf(const std::string& path) const { return root_ / path; }

  /// The content of a regular file of at most 64 MiB; devices and pipes are never opened.
  /// @throws client::PlanFileError
  std::string read(const std::string& path) const;

  /// The file that a URDF's mesh name means, as a path for read(): package://NAME/REST is looked
  /// for below the root with and without NAME and beside the URDF's own folders; other names are
  /// relative to the URDF. Nullopt: there is none.
  std::optional<std::string> findMesh(const std::string& name, const std::string& urdf) const;

 private:
  std::filesystem::path root_;
};

}  // namespace handover::view
