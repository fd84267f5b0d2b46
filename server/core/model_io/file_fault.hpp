// SPDX-License-Identifier: Apache-2.0
// What is wrong with an input file, and where.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace handover {

/// A fault in an input file: `file:line: message`; line 0 when unknown.
struct FileFault {
  std::string file;
  int line = 0;
  std::string message;
  std::string text() const;
};

/// Everything wrong with some input files at once.
class FileError : public std::runtime_error {
 public:
  explicit FileError(std::vector<FileFault> faults);

  const std::vector<FileFault>& faults() const { return faults_; }

 private:
  std::vector<FileFault> faults_;
};

}  // namespace handover
