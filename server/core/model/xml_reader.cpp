// SPDX-License-Identifier: Apache-2.0
#include "core/model/xml_reader.hpp"

#include "core/model/number.hpp"

#include <fstream>
#include <sstream>

namespace handover {
namespace {

constexpr std::uintmax_t kMaxBytes = 16u << 20;

std::string where(const tinyxml2::XMLElement& element, const char* attribute) {
  return described(element) + ": " + attribute;
}

}  // namespace

const tinyxml2::XMLElement* parseXml(const std::filesystem::path& file,
                                     tinyxml2::XMLDocument& document, XmlFaults& faults) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    faults.add(0, "no such file");
    return nullptr;
  }
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error || bytes > kMaxBytes) {
    faults.add(0, error ? "cannot be read" : "larger than 16 MiB");
    return nullptr;
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) {
    faults.add(0, "cannot be read");
    return nullptr;
  }
  const std::string content = text.str();
  if (document.Parse(content.data(), content.size()) != tinyxml2::XML_SUCCESS) {
    faults.add(document.ErrorLineNum(),
               std::string("is not well-formed XML: ") +
                   tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()));
    return nullptr;
  }
  const tinyxml2::XMLElement* root = document.RootElement();
  if (root == nullptr || std::string_view(root->Name()) != "robot") {
    faults.add(root == nullptr ? 0 : root->GetLineNum(), "has no <robot> as its root element");
    return nullptr;
  }
  return root;
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
                               XmlFaults& faults) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return std::nullopt;
  const std::optional<double> value = parseNumber(text);
  if (!value) {
    faults.add(element, where(element, attribute) + " is not a finite number: '" + text + "'");
  }
  return value;
}

std::optional<double> requiredNumber(const tinyxml2::XMLElement& element, const char* attribute,
                                     XmlFaults& faults) {
  if (element.Attribute(attribute) == nullptr) {
    faults.add(element, described(element) + " has no " + attribute);
    return std::nullopt;
  }
  return numberOf(element, attribute, faults);
}

std::optional<Eigen::Vector3d> vectorOf(const tinyxml2::XMLElement& element, const char* attribute,
                                        XmlFaults& faults) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return std::nullopt;
  const std::vector<std::string_view> parts = splitWords(text);
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  bool good = parts.size() == 3;
  for (std::size_t i = 0; good && i < 3; ++i) {
    const std::optional<double> value = parseNumber(parts[i]);
    good = value.has_value();
    vector[static_cast<Eigen::Index>(i)] = value.value_or(0.0);
  }
  if (good) return vector;
  faults.add(element, where(element, attribute) + " is not three finite numbers: '" + text + "'");
  return std::nullopt;
}

void checkOrigin(const tinyxml2::XMLElement& element, XmlFaults& faults) {
  const tinyxml2::XMLElement* origin = element.FirstChildElement("origin");
  if (origin == nullptr) return;
  if (origin->NextSiblingElement("origin") != nullptr) {
    faults.add(*origin->NextSiblingElement("origin"), described(element) + " has two <origin>s");
  }
  vectorOf(*origin, "rpy", faults);
  vectorOf(*origin, "xyz", faults);
}

std::string described(const tinyxml2::XMLElement& element) {
  const char* name = element.Attribute("name");
  const std::string tag = std::string("<") + element.Name() + ">";
  return name == nullptr ? tag : tag + " '" + name + "'";
}

}  // namespace handover
