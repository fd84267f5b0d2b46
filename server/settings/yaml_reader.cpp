// SPDX-License-Identifier: Apache-2.0
#include "settings/yaml_reader.hpp"

#include "core/model_io/file_text.hpp"
#include "core/model_io/number.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <sstream>

namespace handover {
namespace {

constexpr std::uint64_t kMaxMib = 4;
constexpr std::size_t kMaxNameBytes = 64;
constexpr std::size_t kMaxKeyBytes = 512;  // paths of overrides are the longest

std::string shown(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << value;
  return text.str();
}

std::string shown(const YamlNode& node) {
  if (node.isScalar()) return (node.quoted ? "the text '" : "'") + node.text + "'";
  if (node.isList()) return "a list";
  return node.isMap() ? "a map" : "nothing";
}

/// The number that a plain scalar is.
std::optional<double> numberOf(const YamlNode& node) {
  if (!node.isScalar() || node.quoted) return std::nullopt;
  return parseNumber(node.text);
}

bool isNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

/// How many letters have to be put in, taken out or exchanged to make one word of the other.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t exchanged = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearestOf(const std::set<std::string>& words, const std::string& word) {
  const auto nearest =
      std::min_element(words.begin(), words.end(), [&](const std::string& a, const std::string& b) {
        return editDistance(a, word) < editDistance(b, word);
      });
  return nearest == words.end() ? "" : *nearest;
}

std::string nearestSaid(const std::string& nearest) {
  return nearest.empty() ? "" : "; the nearest known one is '" + nearest + "'";
}

void YamlReport::add(const std::string& path, std::string message) {
  addAt(lineOf(path), path, std::move(message));
}

void YamlReport::addAt(int line, const std::string& path, std::string message) {
  faults_.push_back({path, line, oneLine(std::move(message))});
}

int YamlReport::lineOf(const std::string& path) const {
  for (std::string at = path;;) {
    if (const auto known = lines_.find(at); known != lines_.end()) return known->second;
    if (at.empty()) return 0;
    const std::size_t dot = at.rfind('.');
    at = dot == std::string::npos ? "" : at.substr(0, dot);
  }
}

YamlReport YamlReport::linesOnly() const {
  YamlReport report;
  report.lines_ = lines_;
  return report;
}

void YamlReport::addNew(const YamlReport& other) {
  const auto leadsTo = [](const std::string& path, const std::string& inner) {
    return inner.starts_with(path) && (inner.size() == path.size() || inner[path.size()] == '.');
  };
  const std::size_t own = faults_.size();
  for (const YamlFault& fault : other.faults_) {
    const auto known = faults_.begin() + static_cast<std::ptrdiff_t>(own);
    const bool said = std::any_of(faults_.begin(), known, [&](const YamlFault& mine) {
      return leadsTo(mine.path, fault.path) || leadsTo(fault.path, mine.path);
    });
    if (!said) faults_.push_back(fault);
  }
}

std::vector<FileFault> YamlReport::inFile(const std::string& file) const {
  std::vector<FileFault> out;
  for (const YamlFault& fault : faults_) {
    out.push_back(
        {file, fault.line, fault.path.empty() ? fault.message : fault.path + ": " + fault.message});
  }
  return out;
}

YamlValue::YamlValue(const YamlNode& node, std::string path, YamlReport& report, int line)
    : node_(&node), path_(std::move(path)), report_(&report) {
  if (line == 0) line = node.line;
  if (line > 0) report.locate(path_, line);
}

std::optional<std::string> YamlValue::text() const {
  if (node_->isScalar() && !node_->text.empty()) return node_->text;
  fault("must be a text, not " + shown(*node_));
  return std::nullopt;
}

std::optional<std::string> YamlValue::name() const {
  std::optional<std::string> given = text();
  if (given && !checkName(*given)) return std::nullopt;
  return given;
}

bool YamlValue::checkName(const std::string& name) const {
  if (!name.empty() && name.size() <= kMaxNameBytes &&
      std::all_of(name.begin(), name.end(), isNameCharacter)) {
    return true;
  }
  fault("'" + name + "' is not a name: up to " + std::to_string(kMaxNameBytes) +
        " letters, digits, '_' and '-'");
  return false;
}

std::optional<std::string> YamlValue::oneOf(std::initializer_list<const char*> words) const {
  std::string choice;
  for (const char* word : words) {
    if (node_->isScalar() && node_->text == word) return node_->text;
    if (!choice.empty()) choice += ", ";
    choice += word;
  }
  fault("must be one of " + choice + ", not " + shown(*node_));
  return std::nullopt;
}

std::optional<double> YamlValue::number(NumberRange range) const {
  const std::optional<double> value = numberOf(*node_);
  if (!value) {
    fault("must be a finite number, not " + shown(*node_));
    return std::nullopt;
  }
  if (*value >= range.low && *value <= range.high) return value;
  fault("must be within " + shown(range.low) + " and " + shown(range.high) + ", not " +
        shown(*node_));
  return std::nullopt;
}

std::optional<int> YamlValue::integer(int low, int high) const {
  const std::optional<double> value = numberOf(*node_);
  if (value && *value == std::floor(*value) && *value >= low && *value <= high) {
    return static_cast<int>(*value);
  }
  fault("must be a whole number from " + std::to_string(low) + " to " + std::to_string(high) +
        ", not " + shown(*node_));
  return std::nullopt;
}

std::optional<std::vector<double>> YamlValue::numbers(NumberRange range) const {
  const auto entries = list();
  if (!entries) return std::nullopt;
  std::vector<double> values;
  for (const YamlValue& entry : *entries) {
    if (const auto value = entry.number(range)) values.push_back(*value);
  }
  if (values.size() != entries->size()) return std::nullopt;
  return values;
}

std::optional<Eigen::Vector3d> YamlValue::vector(NumberRange range) const {
  if (!node_->isList() || node_->values.size() != 3) {
    fault("must be a list of three numbers");
    return std::nullopt;
  }
  const auto values = numbers(range);
  if (!values) return std::nullopt;
  return Eigen::Vector3d((*values)[0], (*values)[1], (*values)[2]);
}

std::optional<std::vector<YamlValue>> YamlValue::list() const {
  if (!node_->isList()) {
    fault("must be a list, not " + shown(*node_));
    return std::nullopt;
  }
  std::vector<YamlValue> entries;
  for (std::size_t i = 0; i < node_->values.size(); ++i) {
    entries.emplace_back(node_->values[i], joinedPath(path_, std::to_string(i)), *report_);
  }
  return entries;
}

std::optional<std::vector<std::string>> YamlValue::texts() const {
  const auto entries = list();
  if (!entries) return std::nullopt;
  std::vector<std::string> values;
  for (const YamlValue& entry : *entries) {
    if (auto value = entry.text()) values.push_back(std::move(*value));
  }
  if (values.size() != entries->size()) return std::nullopt;
  return values;
}

std::optional<YamlMap> YamlValue::map() const {
  if (!node_->isMap()) {
    fault("must be a map, not " + shown(*node_));
    return std::nullopt;
  }
  std::vector<std::pair<std::string, YamlValue>> entries;
  std::map<std::string, int> keys;
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    if (!node_->keys[i].isScalar()) {
      fault("has a key that is not a text");
      continue;
    }
    const std::string& key = node_->keys[i].text;
    if (key.empty() || key.size() > kMaxKeyBytes) {
      fault(key.empty() ? "has an empty key"
                        : "has a key of " + std::to_string(key.size()) + " bytes");
      continue;
    }
    const int line = node_->keys[i].line;
    if (const auto [first, fresh] = keys.emplace(key, line); !fresh) {
      report_->addAt(
          line, path_,
          "has the key '" + key + "' twice, first in line " + std::to_string(first->second));
      continue;
    }
    entries.emplace_back(
        key, YamlValue(node_->values[i], joinedPath(path_, key), *report_, node_->keys[i].line));
  }
  return YamlMap(std::move(entries), path_, *report_);
}

YamlMap::YamlMap(std::vector<std::pair<std::string, YamlValue>> entries, std::string path,
                 YamlReport& report)
    : entries_(std::move(entries)),
      asked_(entries_.size(), false),
      path_(std::move(path)),
      report_(&report) {}

const std::vector<std::pair<std::string, YamlValue>>& YamlMap::all() {
  asked_.assign(entries_.size(), true);
  return entries_;
}

const YamlValue* YamlMap::find(const std::string& key) {
  known_.insert(key);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].first != key) continue;
    asked_[i] = true;
    return &entries_[i].second;
  }
  return nullptr;
}

const YamlValue* YamlMap::require(const std::string& key) {
  const YamlValue* value = find(key);
  if (value == nullptr) report_->add(path_, "has no '" + key + "'");
  return value;
}

void YamlMap::finish() {
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (asked_[i]) continue;
    report_->add(entries_[i].second.path(),
                 "unknown key" + nearestSaid(nearestOf(known_, entries_[i].first)));
  }
}

std::string joinedPath(const std::string& parent, const std::string& key) {
  return parent.empty() ? key : parent + "." + key;
}

std::string readSettingsText(const std::filesystem::path& file) {
  Result<std::string> text = readFileText(file, kMaxMib);
  if (!text) throw FileError({{file.string(), 0, text.error().detail}});
  return std::move(text).value();
}

}  // namespace handover
