// SPDX-License-Identifier: Apache-2.0
// Does a library of ours link what it includes?
#pragma once

#include "include_rules.hpp"

#include <string>
#include <vector>

namespace handover::test {

/// What a CMakeLists.txt says of one handover_library(): its name and its links, as written.
struct LinkedLibrary {
  std::string name;
  std::vector<std::string> sources, public_links, private_links;
};

/// The libraries of a CMakeLists.txt, in order.
std::vector<LinkedLibrary> linkedLibraries(const std::string& text);

/// Names of the core's modules that the files of a folder include but its library does not link:
/// "kinematics: model" for each. What headers include has to be linked PUBLIC, which adds ", for a
/// header".
/// @param texts  of CMakeLists.txt, by module
std::vector<std::string> missingLinks(const SourceTree& tree,
                                      const std::map<std::string, std::string>& texts);

}  // namespace handover::test
