// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace handover {

/// A YAML value with all it holds. A plain value: copied as a whole, and read from any thread,
/// where yaml-cpp's nodes share and change under reading.
struct YamlNode {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  int line = 0;                  ///< 0: not from a file
  std::string text;              ///< of a scalar
  std::vector<YamlNode> keys;    ///< of a map; a key may be anything, and there twice
  std::vector<YamlNode> values;  ///< of a list, or of a map beside its keys
  bool quoted = false;           ///< a scalar in quotes: a text, never a number

  bool isScalar() const { return kind == Kind::kScalar; }

  bool isList() const { return kind == Kind::kList; }

  bool isMap() const { return kind == Kind::kMap; }

  /// The first value of a map under this key; nullptr if there is none.
  const YamlNode* find(std::string_view key) const;
  YamlNode* find(std::string_view key);

  /// Sets the value under a key of a map; the key comes last if it is new.
  YamlNode& set(const std::string& key, YamlNode value);

  void remove(std::string_view key);

  /// The value written as YAML on one line.
  std::string flowText() const;
};

/// Parses a document, aliases written out. @throws FileError with the line of the syntax fault, and
/// for tags, a second document, more than 50 000 values or 64 levels.
YamlNode parseYaml(const std::string& text, const std::string& shown_file);

}  // namespace handover
