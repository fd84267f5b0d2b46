// SPDX-License-Identifier: Apache-2.0
// The folders of the source tree and what each may include: the table that the tests hold the tree
// to.
#pragma once

#include <string>
#include <vector>

namespace handover::test {

/// A folder with its subfolders, less those that are layers themselves.
struct Layer {
  std::string folder;  ///< from the root, without a slash at its end
  /// Folders of the layers that its files may include, besides itself.
  std::vector<std::string> may_include;
};

/// A library that few layers may include.
struct Library {
  std::string name;
  std::string header;  ///< regular expression: how its headers' names begin
  std::vector<std::string> homes;
  bool only_sources = false;  ///< in .cpp files only: its types show in no header of ours
};

/// Lists everything below common/, client/ and server/.
const std::vector<Layer>& layers();

const std::vector<Library>& libraries();

/// Headers that no file of the core gets to see, through other headers of ours either: regular
/// expression of how their names begin.
const std::string& bannedFromCore();

/// Files of ours that no layer has: made in the build folder.
const std::vector<std::string>& generatedHeaders();

}  // namespace handover::test
