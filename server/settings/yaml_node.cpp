// SPDX-License-Identifier: Apache-2.0
#include "settings/yaml_node.hpp"

#include "core/model/robot_loader.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <utility>

namespace handover {
namespace {

constexpr int kMaxDepth = 64;
constexpr int kMaxValues = 200000;  // what aliases of aliases may unfold to

/// @throws YAML::Exception
YamlNode toNode(const YAML::Node& from, int depth, int& values) {
  if (depth > kMaxDepth) throw YAML::Exception(from.Mark(), "nested too deep");
  if (++values > kMaxValues) throw YAML::Exception(from.Mark(), "too many values");
  YamlNode node;
  node.line = from.Mark().line + 1;
  if (from.IsScalar()) {
    node.kind = YamlNode::Kind::kScalar;
    node.text = from.Scalar();
  } else if (from.IsSequence()) {
    node.kind = YamlNode::Kind::kList;
    for (const auto& entry : from) node.values.push_back(toNode(entry, depth + 1, values));
  } else if (from.IsMap()) {
    node.kind = YamlNode::Kind::kMap;
    for (const auto& entry : from) {
      node.keys.push_back(toNode(entry.first, depth + 1, values));
      node.values.push_back(toNode(entry.second, depth + 1, values));
    }
  }
  return node;
}

void emit(const YamlNode& node, YAML::Emitter& out) {
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      out << YAML::Null;
      break;
    case YamlNode::Kind::kScalar:
      out << node.text;
      break;
    case YamlNode::Kind::kList:
      out << YAML::BeginSeq;
      for (const YamlNode& value : node.values) emit(value, out);
      out << YAML::EndSeq;
      break;
    case YamlNode::Kind::kMap:
      out << YAML::BeginMap;
      for (std::size_t i = 0; i < node.keys.size(); ++i) {
        emit(node.keys[i], out);
        emit(node.values[i], out);
      }
      out << YAML::EndMap;
      break;
  }
}

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  const auto at = std::find_if(keys.begin(), keys.end(), [key](const YamlNode& known) {
    return known.isScalar() && known.text == key;
  });
  return at == keys.end() ? nullptr : &values[static_cast<std::size_t>(at - keys.begin())];
}

YamlNode* YamlNode::find(std::string_view key) {
  return const_cast<YamlNode*>(std::as_const(*this).find(key));
}

YamlNode& YamlNode::set(const std::string& key, YamlNode value) {
  if (YamlNode* known = find(key)) return *known = std::move(value);
  keys.emplace_back().kind = Kind::kScalar;
  keys.back().text = key;
  return values.emplace_back(std::move(value));
}

void YamlNode::remove(std::string_view key) {
  const YamlNode* value = find(key);
  if (value == nullptr) return;
  const auto index = value - values.data();
  keys.erase(keys.begin() + index);
  values.erase(values.begin() + index);
}

std::string YamlNode::flowText() const {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  emit(*this, out);
  return out.c_str();
}

YamlNode parseYaml(const std::string& text, const std::string& shown_file) {
  try {
    int values = 0;
    return toNode(YAML::Load(text), 0, values);
  } catch (const YAML::Exception& error) {
    throw FileError({{shown_file, error.mark.line + 1, "is not well-formed YAML: " + error.msg}});
  }
}

}  // namespace handover
