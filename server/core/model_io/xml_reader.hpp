// SPDX-License-Identifier: Apache-2.0
// Shared by the URDF and SRDF readers: a document, the faults found in it, and attributes as
// values. Numbers are read the same way whatever the process's locale.
#pragma once

#include "core/model_io/file_fault.hpp"
#include "core/model_io/file_text.hpp"

#include <Eigen/Core>
#include <tinyxml2.h>

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace handover {

/// The faults of one file, in the order found.
class XmlFaults {
 public:
  XmlFaults(std::string file, std::vector<FileFault>& faults)
      : file_(std::move(file)), faults_(faults) {}

  void add(int line, std::string message) {
    faults_.push_back({file_, line, oneLine(std::move(message))});
  }

  void add(const tinyxml2::XMLElement& at, std::string message) {
    add(at.GetLineNum(), std::move(message));
  }

 private:
  std::string file_;
  std::vector<FileFault>& faults_;
};

/// Parses a file; nullptr after a fault. At most 16 MiB.
const tinyxml2::XMLElement* parseXml(const std::filesystem::path& file,
                                     tinyxml2::XMLDocument& document, XmlFaults& faults);

/// The first line of an element with more than 256 attributes (tinyxml2 compares each with all
/// before it); 0: there is none.
int lineOfTooManyAttributes(std::string_view text);

/// The `name` attribute or another one that must be there and not empty; "" after a fault.
std::string requiredText(const tinyxml2::XMLElement& element, const char* attribute,
                         XmlFaults& faults);

/// A number attribute of at most `most` either way; nullopt when it is absent (no fault) or wrong
/// (a fault).
std::optional<double> numberOf(const tinyxml2::XMLElement& element, const char* attribute,
                               XmlFaults& faults, double most = 1e9);
/// Absence is a fault as well.
std::optional<double> requiredNumber(const tinyxml2::XMLElement& element, const char* attribute,
                                     XmlFaults& faults, double most = 1e9);

/// Three numbers with spaces between; nullopt as for numberOf().
std::optional<Eigen::Vector3d> vectorOf(const tinyxml2::XMLElement& element, const char* attribute,
                                        XmlFaults& faults, double most = 1000);

/// `count` numbers parted by blanks, each at most `most` either way; nullopt as with numberOf().
std::optional<std::vector<double>> numbersOf(const tinyxml2::XMLElement& element,
                                             const char* attribute, std::size_t count, double most,
                                             XmlFaults& faults);

/// A fault for each attribute that is not among these: probably a typo. Namespaced attributes (with
/// a
/// ':') are ignored.
void checkAttributes(const tinyxml2::XMLElement& element,
                     std::initializer_list<std::string_view> known, XmlFaults& faults);

/// The same for the elements inside; those of `once` are also a fault when they are there twice.
void checkChildren(const tinyxml2::XMLElement& element,
                   std::initializer_list<std::string_view> once,
                   std::initializer_list<std::string_view> any_number, XmlFaults& faults);

/// Checks the <origin xyz= rpy=> child, if there is one.
void checkOrigin(const tinyxml2::XMLElement& element, XmlFaults& faults);

/// Visits every child of this name.
template <typename Visit>
void forEach(const tinyxml2::XMLElement& parent, const char* tag, Visit visit) {
  for (const tinyxml2::XMLElement* e = parent.FirstChildElement(tag); e != nullptr;
       e = e->NextSiblingElement(tag)) {
    visit(*e);
  }
}

/// "<joint> 'name'" for messages.
std::string described(const tinyxml2::XMLElement& element);

}  // namespace handover
