// SPDX-License-Identifier: Apache-2.0
#include "settings/yaml_node.hpp"

#include "core/model_io/file_fault.hpp"
#include "core/model_io/file_text.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

namespace handover {
namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxValues = 50000;  // those that aliases stand for too

/// What we refuse although it is YAML.
struct Refusal {
  int line;
  std::string message;
};

/// Builds the document from the parser's events. yaml-cpp's own nodes don't tell what was quoted or
/// tagged, and are there in full before anyone can see that they are too many.
class DocumentBuilder : public YAML::EventHandler {
 public:
  YamlNode take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (started_) throw Refusal{mark.line + 1, "has a second document"};
    started_ = true;
  }

  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    finish(begun(mark, YamlNode::Kind::kNull), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    checkTag(mark, tag);
    YamlNode node = begun(mark, YamlNode::Kind::kScalar);
    node.text = value;
    node.quoted = tag == "!";
    finish(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchored_.find(anchor);
    if (known == anchored_.end()) throw Refusal{mark.line + 1, "holds an alias of what it lies in"};
    YamlNode node = known->second;
    count(mark.line + 1, node);
    node.line = mark.line + 1;
    finish(std::move(node), 0);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, YamlNode::Kind::kList);
  }

  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, YamlNode::Kind::kMap);
  }

  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlNode node;
    YAML::anchor_t anchor;
  };

  /// "?" and "!" are what yaml-cpp calls plain and quoted values without a tag.
  static void checkTag(const YAML::Mark& mark, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    throw Refusal{mark.line + 1, "has the tag '" + tag + "': none is known here"};
  }

  YamlNode begun(const YAML::Mark& mark, YamlNode::Kind kind) {
    YamlNode node;
    node.kind = kind;
    node.line = mark.line + 1;
    count(node.line, node);
    return node;
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
            YamlNode::Kind kind) {
    checkTag(mark, tag);
    if (open_.size() == kMaxDepth) {
      throw Refusal{mark.line + 1,
                    "is nested deeper than " + std::to_string(kMaxDepth) + " levels"};
    }
    open_.push_back({begun(mark, kind), anchor});
  }

  void close() {
    Open done = std::move(open_.back());
    open_.pop_back();
    finish(std::move(done.node), done.anchor);
  }

  void finish(YamlNode node, YAML::anchor_t anchor) {
    if (anchor != 0) {
      count(node.line, node);
      anchored_[anchor] = node;
    }
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    YamlNode& around = open_.back().node;
    const bool is_key = around.isMap() && around.keys.size() == around.values.size();
    (is_key ? around.keys : around.values).push_back(std::move(node));
  }

  /// Counts a value and all it holds.
  void count(int line, const YamlNode& node) {
    if (++values_ > kMaxValues) {
      throw Refusal{line, "holds more than " + std::to_string(kMaxValues) + " values"};
    }
    for (const YamlNode& key : node.keys) count(line, key);
    for (const YamlNode& value : node.values) count(line, value);
  }

  bool started_ = false;
  std::size_t values_ = 0;
  YamlNode root_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, YamlNode> anchored_;
};

void emit(const YamlNode& node, YAML::Emitter& out) {
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      out << YAML::Null;
      break;
    case YamlNode::Kind::kScalar:
      if (node.quoted) out << YAML::DoubleQuoted;
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
  if (const int line = lineOfBadText(text); line > 0) {
    throw FileError({{shown_file, line, "is not UTF-8 text"}});
  }
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    DocumentBuilder builder;
    while (parser.HandleNextDocument(builder)) continue;
    return builder.take();
  } catch (const Refusal& refusal) {
    throw FileError({{shown_file, refusal.line, refusal.message}});
  } catch (const YAML::Exception& error) {
    throw FileError({{shown_file, error.mark.line + 1, "is not well-formed YAML: " + error.msg}});
  }
}

}  // namespace handover
