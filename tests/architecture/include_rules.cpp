// SPDX-License-Identifier: Apache-2.0
#include "include_rules.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>

namespace handover::test {
namespace {

namespace fs = std::filesystem;

// Where the compiler looks, after the folder of the including file.
constexpr const char* kIncludeFolders[] = {
    "",       "server",         "common",     "common/include",
    "client", "client/include", "client/src", "client/ctl"};

bool startsWith(const std::string& text, const std::string& expression) {
  return std::regex_search(text, std::regex("^(" + expression + ")"));
}

bool contains(const std::vector<std::string>& list, const std::string& entry) {
  return std::find(list.begin(), list.end(), entry) != list.end();
}

bool isHeader(const std::string& file) { return fs::path(file).extension() == ".hpp"; }

bool inCore(const std::string& file) { return file.starts_with("server/core/"); }

std::string resolve(const SourceTree& tree, const std::string& file, const Include& include) {
  std::vector<fs::path> folders;
  if (include.quoted) folders.push_back(fs::path(file).parent_path());
  folders.insert(folders.end(), std::begin(kIncludeFolders), std::end(kIncludeFolders));
  for (const fs::path& folder : folders) {
    const std::string path = (folder / include.name).lexically_normal().generic_string();
    if (tree.contains(path)) return path;
  }
  return {};
}

void checkLibraries(const std::string& file, const Layer& layer, const Include& include,
                    std::vector<Violation>& out) {
  for (const Library& library : libraries()) {
    if (!startsWith(include.name, library.header)) continue;
    if (!contains(library.homes, layer.folder)) {
      out.push_back(
          {Rule::kLibrary, file, include.name + ": " + library.name + " is not for here"});
    } else if (library.only_sources && isHeader(file)) {
      out.push_back({Rule::kHeader, file, include.name + ": " + library.name + " in a header"});
    }
  }
}

void checkInclude(const std::string& file, const Layer& layer, const Include& include,
                  std::vector<Violation>& out) {
  if (include.target.empty()) {
    if (include.quoted && !contains(generatedHeaders(), include.name)) {
      out.push_back({Rule::kNotFound, file, include.name + ": no such file"});
    }
    checkLibraries(file, layer, include, out);
    return;
  }
  const Layer* target = layerOf(include.target);
  if (!target) return;  // said of the file itself
  if (target->folder != layer.folder && !contains(layer.may_include, target->folder)) {
    out.push_back({Rule::kLayer, file,
                   include.name + ": " + layer.folder + " may not include " + target->folder});
  }
}

// What a file of the core gets to see, through headers of ours.
void checkSeen(const SourceTree& tree, const std::string& file, std::vector<Violation>& out) {
  std::set<std::string> seen{file};
  std::vector<std::string> open{file};
  while (!open.empty()) {
    const std::string at = open.back();
    open.pop_back();
    for (const Include& include : includesOf(tree, at)) {
      if (include.target.empty() && startsWith(include.name, bannedFromCore())) {
        out.push_back({Rule::kHiddenInCore, file, include.name + ", included by " + at});
      }
      if (!include.target.empty() && seen.insert(include.target).second) {
        open.push_back(include.target);
      }
    }
  }
}

}  // namespace

SourceTree readSourceTree(const fs::path& root) {
  SourceTree tree;
  for (const char* top : {"common", "client", "server"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".hpp") continue;
      std::ifstream in(entry.path(), std::ios::binary);
      tree[entry.path().lexically_relative(root).generic_string()] = {
          std::istreambuf_iterator<char>(in), {}};
    }
  }
  return tree;
}

const Layer* layerOf(const std::string& file) {
  const Layer* best = nullptr;
  for (const Layer& layer : layers()) {
    if (!file.starts_with(layer.folder + "/")) continue;
    if (layer.folder == "server" && fs::path(file).parent_path() != "server") continue;
    if (!best || layer.folder.size() > best->folder.size()) best = &layer;
  }
  return best;
}

std::vector<Include> includesOf(const SourceTree& tree, const std::string& file) {
  static const std::regex line("^[ \t]*#[ \t]*include(?:_next)?[ \t]*([<\"])([^>\"]+)[>\"]");
  std::vector<Include> found;
  std::istringstream text(tree.at(file));
  for (std::string at; std::getline(text, at);) {
    std::smatch match;
    if (!std::regex_search(at, match, line)) continue;
    Include include{match[2], match[1] == "\"", {}};
    include.target = resolve(tree, file, include);
    found.push_back(include);
  }
  return found;
}

std::vector<Violation> violations(const SourceTree& tree) {
  std::vector<Violation> out;
  for (const auto& [file, text] : tree) {
    const Layer* layer = layerOf(file);
    if (!layer) {
      out.push_back({Rule::kNoLayer, file, "its folder is not in tests/architecture/layers.cpp"});
      continue;
    }
    for (const Include& include : includesOf(tree, file)) checkInclude(file, *layer, include, out);
    if (inCore(file)) checkSeen(tree, file, out);
  }
  return out;
}

}  // namespace handover::test
