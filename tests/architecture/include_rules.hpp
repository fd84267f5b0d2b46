// SPDX-License-Identifier: Apache-2.0
// Which includes of a source tree break the table of layers.hpp?
#pragma once

#include "layers.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace handover::test {

/// Text of the C++ files by path from the root, with '/'.
using SourceTree = std::map<std::string, std::string>;

/// Every .cpp and .hpp below common/, client/ and server/ of `root`.
SourceTree readSourceTree(const std::filesystem::path& root);

enum class Rule {
  kNoLayer,      ///< the file lies in no folder of the table
  kNotFound,     ///< "..." names no file of the tree, and none that is generated
  kLayer,        ///< a layer that this one may not include
  kLibrary,      ///< a library outside its homes
  kHeader,       ///< a library in a header, which is for sources only
  kHiddenInCore  ///< the core sees what it must not, maybe through other headers
};

struct Violation {
  Rule rule;
  std::string file;  ///< where the include stands
  std::string text;  ///< what is wrong, for people
};

/// The layer of a file: the longest folder that holds it; nullptr for none. Of the layer "server"
/// are only files that lie in it directly, so that a new folder needs a line of the table.
const Layer* layerOf(const std::string& file);

/// An include line: <...> or "..."; resolved to a file of the tree where it is one.
struct Include {
  std::string name;
  bool quoted = false;
  std::string target;  ///< path in the tree; empty: not ours
};

std::vector<Include> includesOf(const SourceTree& tree, const std::string& file);

/// Every broken rule of the tree, in order of files and lines.
std::vector<Violation> violations(const SourceTree& tree);

}  // namespace handover::test
