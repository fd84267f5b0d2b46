// SPDX-License-Identifier: Apache-2.0
// A walk over a YAML document that types, checks and locates every value. Faults are collected,
// with the path of keys that leads to the value; a key that nobody asked for is a fault.
#pragma once

#include "core/model_io/file_fault.hpp"
#include "settings/yaml_node.hpp"

#include <Eigen/Core>

#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace handover {

/// Of some words, the one most like another, ties by order; empty if there are none.
std::string nearestOf(const std::set<std::string>& words, const std::string& word);

/// The end of a fault that names an unknown word: "; the nearest known one is '...'", or empty.
std::string nearestSaid(const std::string& nearest);

/// The same of a range of things with a name.
template <typename Named>
std::string nearestNamed(const Named& all, const std::string& word) {
  std::set<std::string> names;
  for (const auto& one : all) names.insert(one.name);
  return nearestSaid(nearestOf(names, word));
}

struct YamlFault {
  std::string path;  ///< keys joined by dots; empty for the document
  int line = 0;      ///< 0: unknown
  std::string message;
};

/// What a walk found out: faults, and the line of every value met.
class YamlReport {
 public:
  void add(const std::string& path, std::string message);
  /// The same for a line of its own within the value.
  void addAt(int line, const std::string& path, std::string message);

  void locate(const std::string& path, int line) { lines_.emplace(path, line); }

  /// The line of the path or of the nearest value that it lies in; 0 if none is known.
  int lineOf(const std::string& path) const;

  const std::vector<YamlFault>& faults() const { return faults_; }

  const std::map<std::string, int>& lines() const { return lines_; }

  bool clean() const { return faults_.empty(); }

  /// Knows the same lines, and no fault.
  YamlReport linesOnly() const;

  /// Takes over the faults of another report that lie neither in nor around a value with a fault.
  void addNew(const YamlReport& other);

  /// The faults as those of a file: `path: message`.
  std::vector<FileFault> inFile(const std::string& file) const;

 private:
  std::vector<YamlFault> faults_;
  std::map<std::string, int> lines_;
};

/// A range of numbers: both ends belong to it.
struct NumberRange {
  double low = -1e9, high = 1e9;
};

class YamlMap;

/// One value with its path.
class YamlValue {
 public:
  /// Lies on `line`, where its key stands; 0: where it starts itself. The node outlives the value.
  YamlValue(const YamlNode& node, std::string path, YamlReport& report, int line = 0);
  YamlValue(YamlNode&&, std::string, YamlReport&, int = 0) = delete;

  const std::string& path() const { return path_; }

  YamlReport& report() const { return *report_; }

  bool isScalar() const { return node_->isScalar(); }

  bool isList() const { return node_->isList(); }

  bool isMap() const { return node_->isMap(); }

  /// Nothing after the colon, or "".
  bool isEmpty() const { return !isList() && !isMap() && node_->text.empty(); }

  void fault(std::string message) const { report_->add(path_, std::move(message)); }

  /// Each returns nullopt after a fault.
  std::optional<std::string> text() const;
  /// A text of [A-Za-z0-9_-], at most 64 of them.
  std::optional<std::string> name() const;
  /// Whether the value's own key is such a name; a fault if not.
  bool checkName(const std::string& name) const;
  std::optional<std::string> oneOf(std::initializer_list<const char*> words) const;
  std::optional<double> number(NumberRange range = {}) const;
  std::optional<int> integer(int low, int high) const;
  std::optional<std::vector<double>> numbers(NumberRange range = {}) const;
  std::optional<Eigen::Vector3d> vector(NumberRange range = {}) const;
  std::optional<std::vector<YamlValue>> list() const;
  std::optional<std::vector<std::string>> texts() const;
  std::optional<YamlMap> map() const;

  /// The value written as YAML on one line.
  std::string flowText() const { return node_->flowText(); }

 private:
  const YamlNode* node_;
  std::string path_;
  YamlReport* report_;
};

/// A map; remembers which keys were asked for.
class YamlMap {
 public:
  YamlMap(std::vector<std::pair<std::string, YamlValue>> entries, std::string path,
          YamlReport& report);

  const std::string& path() const { return path_; }

  /// Every entry in the document's order; all count as asked for.
  const std::vector<std::pair<std::string, YamlValue>>& all();
  /// nullptr when absent.
  const YamlValue* find(const std::string& key);
  /// Absence is a fault.
  const YamlValue* require(const std::string& key);
  /// Faults for the keys that nobody asked for, with the nearest of those that were.
  void finish();

 private:
  std::vector<std::pair<std::string, YamlValue>> entries_;
  std::vector<bool> asked_;
  std::set<std::string> known_;  ///< keys that were asked for
  std::string path_;
  YamlReport* report_;
};

/// `parent.key`, or the key alone at the top.
std::string joinedPath(const std::string& parent, const std::string& key);

/// The text of a file. @throws FileError when it cannot be read or is larger than 4 MiB.
std::string readSettingsText(const std::filesystem::path& file);

}  // namespace handover
