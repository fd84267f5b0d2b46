// SPDX-License-Identifier: Apache-2.0
// A small cell in a temporary folder, and a plan file of it (format handover-plan/2): `duo` takes a
// box with its left arm, passes it to its right one and that to `crane`, which lifts it by a
// suction cup, turns it by a quarter and puts it down. It is about what pages show, so nothing is
// proven of clearances.
#pragma once

#include "temporary_folder.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace handover::view::test {

using Json = nlohmann::ordered_json;

class SampleCell {
 public:
  SampleCell();

  const std::filesystem::path& root() const { return folder_.path(); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }

  Json plan() const;

  /// The same scene; no plan, three causes, a fix, the farthest attempt, and the workspaces.
  Json failure() const;

 private:
  handover::test::TemporaryFolder folder_;
};

/// The stage of a plan file; throws when there is none.
const Json& stageOf(const Json& file, int holder, const std::string& action);

double endOf(const Json& stage);

}  // namespace handover::view::test
