// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/file_fault.hpp"

#include "core/model_io/file_text.hpp"

namespace handover {
namespace {

std::string joinedText(const std::vector<FileFault>& faults) {
  std::string text;
  for (const FileFault& fault : faults) {
    if (!text.empty()) text += '\n';
    text += fault.text();
  }
  return text;
}

}  // namespace

std::string FileFault::text() const {
  const std::string at = line > 0 ? file + ":" + std::to_string(line) : file;
  return at + ": " + oneLine(message);
}

FileError::FileError(std::vector<FileFault> faults)
    : std::runtime_error(joinedText(faults)), faults_(std::move(faults)) {}

}  // namespace handover
