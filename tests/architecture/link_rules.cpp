// SPDX-License-Identifier: Apache-2.0
#include "link_rules.hpp"

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

namespace handover::test {
namespace {

const std::string kCore = "server/core/";

bool contains(const std::vector<std::string>& list, const std::string& entry) {
  return std::find(list.begin(), list.end(), entry) != list.end();
}

LinkedLibrary parse(const std::string& call) {
  LinkedLibrary library;
  std::istringstream words(call);
  words >> library.name;
  std::vector<std::string>* list = &library.sources;
  for (std::string word; words >> word;) {
    if (word == "SOURCES") {
      list = &library.sources;
    } else if (word == "PUBLIC") {
      list = &library.public_links;
    } else if (word == "PRIVATE") {
      list = &library.private_links;
    } else {
      list->push_back(word);
    }
  }
  return library;
}

// By module: whether a header of the folder includes it.
std::map<std::string, bool> includedModules(const SourceTree& tree, const std::string& module) {
  std::map<std::string, bool> included;
  for (const auto& [file, text] : tree) {
    if (!file.starts_with(kCore + module + "/")) continue;
    for (const Include& include : includesOf(tree, file)) {
      const Layer* layer = include.target.empty() ? nullptr : layerOf(include.target);
      if (!layer || !layer->folder.starts_with(kCore)) continue;
      const std::string other = layer->folder.substr(kCore.size());
      if (other != module) included[other] |= file.ends_with(".hpp");
    }
  }
  return included;
}

}  // namespace

std::vector<LinkedLibrary> linkedLibraries(const std::string& text) {
  static const std::regex call("handover_library\\(([^)]*)\\)");
  std::vector<LinkedLibrary> found;
  for (std::sregex_iterator it(text.begin(), text.end(), call), end; it != end; ++it) {
    found.push_back(parse((*it)[1]));
  }
  return found;
}

std::vector<std::string> missingLinks(const SourceTree& tree,
                                      const std::map<std::string, std::string>& texts) {
  std::vector<std::string> missing;
  for (const auto& [module, text] : texts) {
    const std::vector<LinkedLibrary> libraries = linkedLibraries(text);
    for (const auto& [other, in_header] : includedModules(tree, module)) {
      const std::string link = "handover::" + other;
      const auto links = [&](const LinkedLibrary& it) {
        return contains(it.public_links, link) || (!in_header && contains(it.private_links, link));
      };
      if (std::any_of(libraries.begin(), libraries.end(), links)) continue;
      missing.push_back(module + ": " + other + (in_header ? ", for a header" : ""));
    }
  }
  return missing;
}

}  // namespace handover::test
