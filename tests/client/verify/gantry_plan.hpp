// SPDX-License-Identifier: Apache-2.0
// A small cell made in a temporary folder, and plans for it that are right in every respect:
// gantries with wrists and two-finger grippers, or suction cups, bring a box from a table to a
// shelf. Tests spoil them in one place each.
#pragma once

#include "support/temporary_folder.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace handover::verify::test {

using Json = nlohmann::json;

struct PlanOptions {
  int holders = 2;             ///< 1 to 3
  bool held_at_start = false;  ///< the first has the box in hand
  bool ends_held = false;      ///< the last keeps it
  bool suction = false;        ///< all of them
  bool joined = false;         ///< lift and carry, retreat and home without a stop
  bool upright = false;
  double slack = 0.25;         ///< [s]
  double last_retreat = 0.15;  ///< [m]
  double closed = 0.0205;      ///< [m] of each finger: half a millimetre from the box
};

/// Folder with robots/gantry and robots/cup; removed in the end.
class GantryCell {
 public:
  GantryCell();

  const std::filesystem::path& root() const { return root_.path(); }

  void write(const std::string& file, const std::string& text) const;

  /// The right plan.
  Json plan(const PlanOptions& options = {}) const;

 private:
  handover::test::TemporaryFolder root_;
};

/// The holder's stage of that action in the plan file.
Json& stage(Json& file, int holder, const std::string& action);
/// The named object or robot of the plan file.
Json& object(Json& file, const std::string& name);
Json& robot(Json& file, const std::string& name);

/// Sets every start as early as the stages' `after` allows.
void startEarly(Json& file);

Json pose(const std::vector<double>& xyz, const std::vector<double>& quat = {1, 0, 0, 0});
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
