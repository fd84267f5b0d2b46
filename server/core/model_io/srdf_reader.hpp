// SPDX-License-Identifier: Apache-2.0
// SRDF as written, names checked against the URDF's; every fault with its line.
#pragma once

#include "core/model_io/file_fault.hpp"
#include "core/model_io/urdf_reader.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace handover {

struct SrdfGroup {
  int line = 0;
  std::vector<JointId> joints;  ///< movable ones, mimic ones too, ascending: chains run base to tip
};

struct SrdfModel {
  std::map<std::string, SrdfGroup> groups;
  /// Group state name -> joint -> position; states of one name over several groups are
  /// merged.
  std::map<std::string, std::map<JointId, double>> states;
  std::map<std::pair<LinkId, LinkId>, std::string> disabled_pairs;  ///< lower link first -> reason
};

/// Faults are appended; the result is usable only if none were.
SrdfModel readSrdf(const std::filesystem::path& file, const std::string& shown_file,
                   const UrdfModel& urdf, std::vector<FileFault>& faults);

}  // namespace handover
