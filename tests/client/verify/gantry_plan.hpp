// SPDX-License-Identifier: Apache-2.0
// A small cell made in a temporary folder, and a plan for it that is right in every respect: two
// gantries with wrists and two-finger grippers hand a box over. Tests spoil it in one place each.
#pragma once

#include "support/temporary_folder.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace handover::verify::test {

using Json = nlohmann::json;

/// Folder with robots/gantry/gantry.urdf and .srdf; removed in the end.
class GantryCell {
 public:
  GantryCell();

  const std::filesystem::path& root() const { return root_.path(); }

  void write(const std::string& file, const std::string& text) const;

  /// The right plan.
  Json plan() const;

 private:
  handover::test::TemporaryFolder root_;
};

/// The stage of that kind in the plan file.
Json& stage(Json& file, const std::string& kind);
/// The named object or robot of the plan file.
Json& object(Json& file, const std::string& name);
Json& robot(Json& file, const std::string& name);

Json boxObject(const std::string& name, const std::vector<double>& size,
               const std::vector<double>& xyz);

struct ProgramResult {
  int exit_code = -1;
  std::string output;              ///< standard output
  Json json;                       ///< of --json
  std::vector<std::string> kinds;  ///< of the violations
};

/// Runs the real handover-verify on the plan.
ProgramResult verify(const GantryCell& cell, const Json& plan);
ProgramResult verifyText(const GantryCell& cell, const std::string& text);
/// Runs it with these arguments as they are.
ProgramResult run(const std::string& arguments);

}  // namespace handover::verify::test
