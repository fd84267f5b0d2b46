// SPDX-License-Identifier: Apache-2.0
#include "settings/cell_overrides.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>

namespace handover {
namespace {

constexpr std::size_t kMaxDepth = 16;
constexpr std::size_t kMaxValueBytes = 65536;

std::vector<std::string> splitPath(const std::string& path) {
  std::vector<std::string> keys;
  std::size_t at = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', at)) {
    keys.push_back(path.substr(at, dot - at));
    at = dot + 1;
  }
  keys.push_back(path.substr(at));
  return keys;
}

std::string unknownPath(const std::string& why, const std::string& nearest) {
  return "unknown path" + why + nearestSaid(nearest);
}

/// What is wrong with the path before anything is set; empty if nothing.
std::string pathFault(const YamlNode& document, const std::vector<std::string>& keys) {
  const bool blank = std::any_of(keys.begin(), keys.end(), [](const auto& k) { return k.empty(); });
  if (blank || keys.size() > kMaxDepth) return "unknown path";
  const std::string& part = keys[0];
  if (part == "version" || part == "name" || part == "vary") return "cannot be overridden";
  const std::set<std::string> parts{"objects", "robots", "tasks"};
  if (!parts.contains(part)) return unknownPath("", nearestOf(parts, part));
  if (keys.size() < 2) return "names no entry of " + part;
  const YamlNode* entries = document.find(part);
  if (entries != nullptr && entries->find(keys[1]) != nullptr) return "";
  std::set<std::string> names;
  if (entries != nullptr) {
    for (const YamlNode& name : entries->keys) names.insert(name.text);
  }
  const std::string nearest = nearestOf(names, keys[1]);
  return unknownPath(": no '" + keys[1] + "' in " + part,
                     nearest.empty() ? "" : part + "." + nearest);
}

/// Sets keys[at...] below `node`; false if a key cannot lead on.
bool setBelow(YamlNode& node, const std::vector<std::string>& keys, std::size_t at,
              YamlNode value) {
  const std::string& key = keys[at];
  const bool last = at + 1 == keys.size();
  if (node.isList()) {
    const auto named =
        std::find_if(node.values.begin(), node.values.end(), [&key](const YamlNode& entry) {
          const YamlNode* name = entry.find("name");
          return name != nullptr && name->isScalar() && name->text == key;
        });
    if (named == node.values.end()) return false;
    if (!last) return setBelow(*named, keys, at + 1, std::move(value));
    *named = std::move(value);
    return true;
  }
  if (!node.isMap()) return false;
  if (!last) {
    YamlNode* below = node.find(key);
    if (below == nullptr) {
      below = &node.set(key, YamlNode{YamlNode::Kind::kMap, 0, {}, {}, {}});
    }
    return setBelow(*below, keys, at + 1, std::move(value));
  }
  // A rotation given one way replaces one given the other way.
  if (key == "rpy_deg") node.remove("quat_wxyz");
  if (key == "quat_wxyz") node.remove("rpy_deg");
  node.set(key, std::move(value));
  return true;
}

std::string overrideFault(YamlNode& document, const Override& change) {
  const std::vector<std::string> keys = splitPath(change.path);
  if (std::string fault = pathFault(document, keys); !fault.empty()) return fault;
  if (change.value.size() > kMaxValueBytes) return "the value is too long";
  try {
    return setBelow(document, keys, 0, parseYaml(change.value, "")) ? "" : "unknown path";
  } catch (const FileError& error) {
    return "the value " + error.faults()[0].message;
  }
}

bool leadsTo(std::string_view path, std::string_view inner) {
  return inner == path || (inner.size() > path.size() && inner.starts_with(path) &&
                           (path.empty() || inner[path.size()] == '.'));
}

}  // namespace

std::vector<Fault> applyOverrides(YamlNode& document, const std::vector<Override>& overrides) {
  std::vector<Fault> faults;
  for (const Override& change : overrides) {
    std::string fault = overrideFault(document, change);
    if (!fault.empty()) faults.push_back({change.path, std::move(fault)});
  }
  return faults;
}

std::vector<Fault> asOverrideFaults(const YamlReport& report,
                                    const std::vector<Override>& overrides) {
  std::vector<Fault> faults;
  for (const YamlFault& fault : report.faults()) {
    const auto source =
        std::find_if(overrides.rbegin(), overrides.rend(), [&fault](const Override& change) {
          return leadsTo(change.path, fault.path) || leadsTo(fault.path, change.path);
        });
    if (source == overrides.rend()) {
      faults.push_back({fault.path, fault.message});
    } else if (source->path == fault.path) {
      faults.push_back({source->path, fault.message});
    } else {
      faults.push_back({source->path, fault.path + ": " + fault.message});
    }
  }
  return faults;
}

}  // namespace handover
