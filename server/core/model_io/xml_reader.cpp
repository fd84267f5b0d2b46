// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/xml_reader.hpp"

#include "core/model_io/file_text.hpp"
#include "core/model_io/number.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

namespace handover {
namespace {

constexpr std::uint64_t kMaxMib = 16;
constexpr std::size_t kMaxAttributes = 256;

std::string where(const tinyxml2::XMLElement& element, const char* attribute) {
  return described(element) + ": " + attribute;
}

std::string shown(double value) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

std::string inWords(std::size_t count) { return count == 3 ? "three" : std::to_string(count); }

}  // namespace

const tinyxml2::XMLElement* parseXml(const std::filesystem::path& file,
                                     tinyxml2::XMLDocument& document, XmlFaults& faults) {
  const Result<std::string> content = readFileText(file, kMaxMib);
  if (!content) {
    faults.add(0, content.error().detail);
    return nullptr;
  }
  if (const int line = lineOfBadText(*content); line > 0) {
    faults.add(line, "is not UTF-8 text");
    return nullptr;
  }
  if (const int line = lineOfTooManyAttributes(*content); line > 0) {
    faults.add(line,
               "has an element with more than " + std::to_string(kMaxAttributes) + " attributes");
    return nullptr;
  }
  if (document.Parse(content->data(), content->size()) != tinyxml2::XML_SUCCESS) {
    faults.add(document.ErrorLineNum(),
               std::string("is not well-formed XML: ") +
                   tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()));
    return nullptr;
  }
  for (const auto* node = document.FirstChild(); node != nullptr; node = node->NextSibling()) {
    if (node->ToUnknown() == nullptr) continue;
    faults.add(node->GetLineNum(), "has a document type: entities are not read");
    return nullptr;
  }
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr || std::string_view(root->Name()) != "robot") {
    faults.add(root == nullptr ? 0 : root->GetLineNum(), "has no <robot> as its root element");
    return nullptr;
  }
  return root;
}

int lineOfTooManyAttributes(std::string_view text) {
  const auto after = [&text](std::string_view end, std::size_t from) {
    const std::size_t at = text.find(end, from);
    return at == text.npos ? text.size() : at + end.size();
  };
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    if (text.substr(at).starts_with("<!--")) {
      at = after("-->", at);
    } else if (text.substr(at).starts_with("<![CDATA[")) {
      at = after("]]>", at);
    } else {
      std::size_t attributes = 0;
      for (++at; at < text.size() && text[at] != '>'; ++at) {
        if (text[at] == '"' || text[at] == '\'') at = after(text.substr(at, 1), at + 1) - 1;
        if (at < text.size() && text[at] == '=' && ++attributes > kMaxAttributes) {
          return 1 + static_cast<int>(std::count(
                         text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
        }
      }
    }
  }
  return 0;
}

std::string requiredText(const tinyxml2::XMLElement& element, const char* attribute,
                         XmlFaults& faults) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr || *text == '\0') {
    faults.add(element, described(element) + " has no " + attribute);
    return "";
  }
  return text;
}

std::optional<double> numberOf(const tinyxml2::XMLElement& element, const char* attribute,
                               XmlFaults& faults, double most) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return std::nullopt;
  const std::optional<double> value = parseNumber(text);
  if (!value) {
    faults.add(element, where(element, attribute) + " is not a finite number: '" + text + "'");
  } else if (std::abs(*value) > most) {
    faults.add(element,
               where(element, attribute) + " is beyond " + shown(most) + ": '" + text + "'");
    return std::nullopt;
  }
  return value;
}

std::optional<double> requiredNumber(const tinyxml2::XMLElement& element, const char* attribute,
                                     XmlFaults& faults, double most) {
  if (element.Attribute(attribute) == nullptr) {
    faults.add(element, described(element) + " has no " + attribute);
    return std::nullopt;
  }
  return numberOf(element, attribute, faults, most);
}

std::optional<std::vector<double>> numbersOf(const tinyxml2::XMLElement& element,
                                             const char* attribute, std::size_t count, double most,
                                             XmlFaults& faults) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return std::nullopt;
  std::vector<double> numbers;
  for (const std::string_view part : splitWords(text)) {
    const std::optional<double> value = parseNumber(part);
    if (!value) break;
    numbers.push_back(*value);
  }
  if (numbers.size() != count || splitWords(text).size() != count) {
    faults.add(element, where(element, attribute) + " is not " + inWords(count) +
                            " finite numbers: '" + text + "'");
    return std::nullopt;
  }
  for (const double value : numbers) {
    if (std::abs(value) <= most) continue;
    faults.add(element,
               where(element, attribute) + " is beyond " + shown(most) + ": '" + text + "'");
    return std::nullopt;
  }
  return numbers;
}

std::optional<Eigen::Vector3d> vectorOf(const tinyxml2::XMLElement& element, const char* attribute,
                                        XmlFaults& faults, double most) {
  const auto numbers = numbersOf(element, attribute, 3, most, faults);
  if (!numbers) return std::nullopt;
  return Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

void checkAttributes(const tinyxml2::XMLElement& element,
                     std::initializer_list<std::string_view> known, XmlFaults& faults) {
  for (const auto* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
    const std::string_view name = a->Name();
    if (name.find(':') != name.npos || std::find(known.begin(), known.end(), name) != known.end()) {
      continue;
    }
    faults.add(a->GetLineNum(), described(element) + " has the unknown attribute " + a->Name());
  }
}

void checkChildren(const tinyxml2::XMLElement& element,
                   std::initializer_list<std::string_view> once,
                   std::initializer_list<std::string_view> any_number, XmlFaults& faults) {
  std::set<std::string_view> seen;
  for (const auto* e = element.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string_view name = e->Name();
    if (std::find(once.begin(), once.end(), name) != once.end()) {
      if (seen.insert(name).second) continue;
      faults.add(*e, described(element) + " has two <" + e->Name() + ">s");
    } else if (name.find(':') == name.npos &&
               std::find(any_number.begin(), any_number.end(), name) == any_number.end()) {
      faults.add(*e, described(element) + " has the unknown element <" + e->Name() + ">");
    }
  }
}

void checkOrigin(const tinyxml2::XMLElement& element, XmlFaults& faults) {
  const tinyxml2::XMLElement* origin = element.FirstChildElement("origin");
  if (origin == nullptr) return;
  checkAttributes(*origin, {"xyz", "rpy"}, faults);
  vectorOf(*origin, "rpy", faults);
  vectorOf(*origin, "xyz", faults);
}

std::string described(const tinyxml2::XMLElement& element) {
  const char* name = element.Attribute("name");
  const std::string tag = std::string("<") + element.Name() + ">";
  return name == nullptr ? tag : tag + " '" + name + "'";
}

}  // namespace handover
