// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/mesh_checker.hpp"

#include "core/model_io/number.hpp"
#include "core/model_io/xml_reader.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string_view>

namespace handover {
namespace {

constexpr std::size_t kMostFaults = 20;
constexpr std::size_t kMostCorners = 256;  // of one polygon
constexpr std::size_t kMostNested = 256;
constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;

using Words = std::vector<std::string_view>;

Words wordsOf(std::string_view line) {
  static constexpr std::string_view kBlanks = " \t\r\n\v\f";
  Words words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != line.npos;
       at = line.find_first_not_of(kBlanks, at)) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

/// Up to kMostFaults of one file.
class Faults {
 public:
  explicit Faults(const std::filesystem::path& file) : file_(file.string()) {}

  void add(int line, std::string message) {
    if (!full()) found_.push_back({file_, line, std::move(message)});
  }

  bool full() const { return found_.size() >= kMostFaults; }

  std::vector<FileFault> take() { return std::move(found_); }

  /// Each of the words must be a finite number.
  void checkNumbers(int line, const Words& words, std::size_t first, const std::string& what) {
    for (std::size_t i = first; i < words.size(); ++i) {
      if (parseNumber(words[i])) continue;
      return add(line, what + " is not a finite number: '" + std::string(words[i]) + "'");
    }
  }

 private:
  std::string file_;
  std::vector<FileFault> found_;
};

std::string more(std::size_t most, const char* what) {
  return "has more than " + std::to_string(most) + " " + what;
}

/// Hands every line's words to `visit`, with the line's number, until it returns false.
template <typename Visit>
void forEachLine(std::string_view text, Visit visit) {
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    ++number;
    if (!visit(number, text.substr(at, end - at))) return;
    at = end + 1;
  }
}

// ---- OBJ

class ObjChecker {
 public:
  explicit ObjChecker(Faults& faults) : faults_(faults) {}

  void check(std::string_view text) {
    // Faces may come before their vertices.
    forEachLine(text, [this](int, std::string_view line) {
      vertices_ += line.starts_with("v ") || line.starts_with("v\t");
      return true;
    });
    forEachLine(text, [this](int number, std::string_view line) {
      return checkLine(number, line) && !faults_.full();
    });
  }

 private:
  /// False when there is no point in going on.
  bool checkLine(int number, std::string_view line) {
    const bool continued = continued_;  // such lines are left to assimp
    continued_ = line.ends_with("\\") || line.ends_with("\\\r");
    line = line.substr(0, line.find('#'));
    if (line.size() < 2 || continued || continued_) return true;
    const std::string_view kind = line.substr(0, line.find_first_of(" \t\r"));
    if (kind == "v") {
      const Words words = wordsOf(line);
      if (words.size() < 4) faults_.add(number, "a vertex has fewer than three numbers");
      faults_.checkNumbers(number, words, 1, "vertex");
    } else if (kind == "f") {
      return checkFace(number, wordsOf(line));
    } else if (kind == "o" || kind == "g" || kind == "usemtl") {
      if (++parts_ > kMaxMeshParts) {
        faults_.add(number, more(kMaxMeshParts, "objects, groups and materials"));
        return false;
      }
    }
    return true;
  }

  bool checkFace(int number, const Words& words) {
    const std::size_t corners = words.size() - 1;
    if (corners > kMostCorners) {
      faults_.add(number, "a face has " + std::to_string(corners) + " corners, more than " +
                              std::to_string(kMostCorners));
    }
    triangles_ += corners < 3 ? 1 : corners - 2;
    if (triangles_ > kMaxMeshTriangles) {
      faults_.add(number, more(kMaxMeshTriangles, "triangles"));
      return false;
    }
    for (std::size_t i = 1; i < words.size(); ++i) {
      const std::string_view index = words[i].substr(0, words[i].find('/'));
      long long value = 0;
      const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), value);
      const bool whole = error == std::errc() && end == index.data() + index.size();
      if (whole && value != 0 && std::abs(value) <= vertices_) continue;
      faults_.add(number, "a face names vertex '" + std::string(words[i]) + "' of " +
                              std::to_string(vertices_));
      break;
    }
    return true;
  }

  Faults& faults_;
  long long vertices_ = 0;
  std::size_t triangles_ = 0, parts_ = 0;
  bool continued_ = false;
};

// ---- STL

std::uint32_t stlCount(const std::string& text) {
  static_assert(std::endian::native == std::endian::little);
  std::uint32_t count = 0;
  std::memcpy(&count, text.data() + kStlHeader - sizeof(count), sizeof(count));
  return count;
}

void checkBinaryStl(const std::string& text, Faults& faults) {
  const std::size_t count = stlCount(text);
  if (count > kMaxMeshTriangles) return faults.add(0, more(kMaxMeshTriangles, "triangles"));
  for (std::size_t i = 0; i < count && !faults.full(); ++i) {
    float corners[9];  // after the normal
    std::memcpy(corners, text.data() + kStlHeader + i * kStlTriangle + 12, sizeof(corners));
    if (std::all_of(std::begin(corners), std::end(corners),
                    [](float v) { return std::isfinite(v); }))
      continue;
    faults.add(0, "triangle " + std::to_string(i) + " has a vertex that is not finite");
  }
}

void checkStl(const std::string& text, Faults& faults) {
  // "solid" begins many a binary file too: the size decides.
  if (text.size() >= kStlHeader && text.size() == kStlHeader + kStlTriangle * stlCount(text)) {
    return checkBinaryStl(text, faults);
  }
  if (!text.starts_with("solid")) {
    const std::size_t fits =
        text.size() < kStlHeader ? 0 : (text.size() - kStlHeader) / kStlTriangle;
    return faults.add(0, "is no STL: neither a text that begins with 'solid', nor a count of " +
                             std::string("triangles that fits the size, ") + std::to_string(fits));
  }
  std::size_t vertices = 0;
  forEachLine(text, [&](int number, std::string_view line) {
    if (line.find("vertex") == line.npos) return true;
    const Words words = wordsOf(line);
    if (words.empty() || words[0] != "vertex") return true;
    if (words.size() != 4) faults.add(number, "a vertex has not three numbers");
    faults.checkNumbers(number, words, 1, "vertex");
    if (++vertices > 3 * kMaxMeshTriangles) faults.add(0, more(kMaxMeshTriangles, "triangles"));
    return !faults.full() && vertices <= 3 * kMaxMeshTriangles;
  });
}

// ---- Collada

using tinyxml2::XMLElement;

class ColladaChecker {
 public:
  ColladaChecker(const std::string& text, Faults& faults) : bytes_(text.size()), faults_(faults) {}

  void check(const std::string& text) {
    if (const int line = lineOfTooManyAttributes(text); line > 0) {
      return faults_.add(line, "has an element with too many attributes");
    }
    tinyxml2::XMLDocument document;
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
      return faults_.add(document.ErrorLineNum(),
                         std::string("is not well-formed XML: ") +
                             tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()));
    }
    const XMLElement* root = document.RootElement();
    if (root == nullptr || std::string_view(root->Name()) != "COLLADA") {
      return faults_.add(root == nullptr ? 0 : root->GetLineNum(), "has no <COLLADA> as its root");
    }
    walk(*root);  // at most 100 levels, tinyxml2's own bound
    for (const XMLElement* accessor : accessors_) checkAccessor(*accessor);
    for (const XMLElement* input : inputs_) {
      const char* source = input->Attribute("source");
      if (source == nullptr || sources_.contains(idOf(source))) continue;
      faults_.add(input->GetLineNum(), "<input>: no source '" + std::string(source) + "'");
    }
    for (const XMLElement* scene : scenes_) {
      if (partsOf(*scene, 0) > kMaxMeshParts) {
        faults_.add(scene->GetLineNum(), more(kMaxMeshParts, "nodes and instances"));
      }
    }
  }

 private:
  struct Visit {
    bool open = false;
    std::size_t parts = 0;
  };

  void walk(const XMLElement& element) {
    const std::string_view name = element.Name();
    if (name == "unit") checkUnit(element);
    if (name == "visual_scene") scenes_.push_back(&element);
    for (const char* key : {"id", "name", "sid"}) {  // assimp looks for all three
      const char* value = element.Attribute(key);
      if (name == "node" && value != nullptr) nodes_.emplace(value, &element);
    }
    if (name == "float_array" || name == "translate" || name == "rotate" || name == "scale" ||
        name == "matrix" || name == "lookat" || name == "skew" || name == "color") {
      const char* text = element.GetText();
      if (text != nullptr) {
        faults_.checkNumbers(element.GetLineNum(), wordsOf(text), 0, "<" + std::string(name) + ">");
      }
    }
    if (name == "p" || name == "v" || name == "vcount") checkIndices(element);
    if (name == "vcount") checkCorners(element);
    if (name == "accessor") accessors_.push_back(&element);
    if (name == "input") inputs_.push_back(&element);
    if (const char* id = element.Attribute("id"); id != nullptr) {
      if (name == "source" || name == "vertices") sources_.insert(id);
      if (name.ends_with("_array")) arrays_.emplace(id, checkArray(element));
    }
    checkRequired(element);
    for (const char* size : {"count", "stride", "offset"}) checkSize(element, size);
    for (const auto* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      walk(*e);
    }
  }

  /// Without these assimp reads what is not there.
  void checkRequired(const XMLElement& element) {
    static const std::map<std::string_view, std::vector<const char*>> kRequired = {
        {"float_array", {"id", "count"}},
        {"Name_array", {"id", "count"}},
        {"IDREF_array", {"id", "count"}},
        {"int_array", {"id", "count"}},
        {"accessor", {"source", "count"}},
        {"source", {"id"}},
        {"geometry", {"id"}},
        {"vertices", {"id"}},
        {"input", {"semantic", "source"}},
        {"triangles", {"count"}},
        {"trifans", {"count"}},
        {"tristrips", {"count"}},
        {"polylist", {"count"}},
        {"polygons", {"count"}},
        {"lines", {"count"}},
        {"linestrips", {"count"}},
        {"instance_geometry", {"url"}},
        {"instance_node", {"url"}},
        {"instance_visual_scene", {"url"}}};
    const auto required = kRequired.find(element.Name());
    if (required == kRequired.end()) return;
    for (const char* attribute : required->second) {
      if (const char* text = element.Attribute(attribute); text != nullptr && *text != '\0')
        continue;
      faults_.add(element.GetLineNum(),
                  "<" + std::string(element.Name()) + "> has no " + attribute);
    }
  }

  static std::string idOf(const char* reference) {
    return *reference == '#' ? reference + 1 : reference;
  }

  /// How many values an array has.
  double checkArray(const XMLElement& array) {
    const char* text = array.GetText();
    const std::size_t values = wordsOf(text == nullptr ? "" : text).size();
    const char* count = array.Attribute("count");
    if (count != nullptr && parseNumber(count) != static_cast<double>(values)) {
      faults_.add(array.GetLineNum(), "<" + std::string(array.Name()) + "> has " +
                                          std::to_string(values) + " values, not '" + count + "'");
    }
    return static_cast<double>(values);
  }

  void checkAccessor(const XMLElement& accessor) {
    const auto number = [&accessor](const char* attribute, double otherwise) {
      const char* text = accessor.Attribute(attribute);
      return text == nullptr ? otherwise : parseNumber(text).value_or(otherwise);
    };
    const char* source = accessor.Attribute("source");
    if (source == nullptr) return;  // said already
    const auto array = arrays_.find(idOf(source));
    if (array == arrays_.end()) {
      return faults_.add(accessor.GetLineNum(),
                         "<accessor>: no array '" + std::string(source) + "'");
    }
    const double stride = number("stride", 1);
    if (stride < 1 || number("offset", 0) + number("count", 0) * stride > array->second) {
      faults_.add(accessor.GetLineNum(), "<accessor> reaches beyond its array");
    }
  }

  void checkUnit(const XMLElement& unit) {
    const char* meter = unit.Attribute("meter");
    if (meter == nullptr) return;
    const std::optional<double> value = parseNumber(meter);
    if (value && *value >= 1e-9 && *value <= 1e9) return;
    faults_.add(unit.GetLineNum(),
                "<unit>: meter is not a number above 0: '" + std::string(meter) + "'");
  }

  /// Of a word that is no index assimp makes indices without end.
  void checkIndices(const XMLElement& list) {
    const char* text = list.GetText();
    for (const std::string_view word : wordsOf(text == nullptr ? "" : text)) {
      const bool whole =
          std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
      if (whole && word.size() < 10) continue;
      return faults_.add(list.GetLineNum(), "<" + std::string(list.Name()) +
                                                "> is not of whole numbers: '" + std::string(word) +
                                                "'");
    }
  }

  void checkCorners(const XMLElement& vcount) {
    const char* text = vcount.GetText();
    for (const std::string_view word : wordsOf(text == nullptr ? "" : text)) {
      const std::optional<double> corners = parseNumber(word);
      if (corners && *corners >= 0 && *corners <= kMostCorners) continue;
      return faults_.add(vcount.GetLineNum(), "a polygon has " + std::string(word) +
                                                  " corners, not 0 to " +
                                                  std::to_string(kMostCorners));
    }
  }

  void checkSize(const XMLElement& element, const char* attribute) {
    const char* text = element.Attribute(attribute);
    if (text == nullptr) return;
    const std::optional<double> value = parseNumber(text);
    if (value && *value >= 0 && *value <= static_cast<double>(bytes_) &&
        *value == std::floor(*value)) {
      return;
    }
    faults_.add(element.GetLineNum(), "<" + std::string(element.Name()) + ">: " + attribute +
                                          " does not fit the file: '" + text + "'");
  }

  /// Nodes and instances in a node, those of other nodes that it instances as often as it does.
  std::size_t partsOf(const XMLElement& node, std::size_t depth) {
    if (depth > kMostNested) {
      faults_.add(node.GetLineNum(), "<node> is nested too deep");
      return 1;
    }
    Visit& visit = visits_[&node];
    if (visit.open) {
      faults_.add(node.GetLineNum(), "<node> holds an instance of itself");
      return 0;
    }
    if (visit.parts > 0) return visit.parts;
    visit.open = true;
    std::size_t parts = 1;
    for (const auto* e = node.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
      const std::string_view name = e->Name();
      if (name == "node") {
        parts += partsOf(*e, depth + 1);
      } else if (const char* url = e->Attribute("url"); name == "instance_node" && url != nullptr) {
        const auto [first, last] = nodes_.equal_range(*url == '#' ? url + 1 : url);
        for (auto target = first; target != last && !faults_.full(); ++target) {
          parts += partsOf(*target->second, depth + 1);
        }
      } else if (name.starts_with("instance_")) {
        ++parts;
      }
      parts = std::min(parts, 2 * kMaxMeshParts);  // no overflow
    }
    visit.open = false;
    return visit.parts = parts;
  }

  std::size_t bytes_;
  Faults& faults_;
  std::vector<const XMLElement*> scenes_, accessors_, inputs_;
  std::map<std::string, double> arrays_;
  std::set<std::string> sources_;
  std::multimap<std::string, const XMLElement*> nodes_;
  std::map<const XMLElement*, Visit> visits_;
};

}  // namespace

std::vector<FileFault> meshFaults(const std::filesystem::path& file, MeshFormat format,
                                  const std::string& text) {
  Faults faults(file);
  switch (format) {
    case MeshFormat::kStl:
      checkStl(text, faults);
      break;
    case MeshFormat::kObj:
      ObjChecker(faults).check(text);
      break;
    case MeshFormat::kDae:
      ColladaChecker(text, faults).check(text);
      break;
  }
  return faults.take();
}

}  // namespace handover
