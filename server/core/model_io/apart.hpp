// SPDX-License-Identifier: Apache-2.0
// Work with foreign libraries on foreign files, in a child process: whatever a file does to the
// library, this process goes on.
#pragma once

#include <handover/common/result.hpp>

#include <functional>
#include <memory>
#include <string>

namespace handover {

/// A child process that does one sort of work, text to text, time after time: made at the first
/// time, and again after it ended. It is a copy of this process with one thread: `work` may
/// allocate, but takes no lock that others may hold. One thread at a time.
class Apart {
 public:
  using Work = std::function<std::string(const std::string& given)>;

  explicit Apart(Work work);

  ~Apart();
  Apart(const Apart&) = delete;
  Apart& operator=(const Apart&) = delete;

  /// What `work` returned; else how that ended: what it threw, or that the child crashed, took more
  /// than a minute of a processor, or more than 4 GiB.
  Result<std::string> operator()(const std::string& given);

 private:
  struct Child;

  /// Null, and errno, when it cannot be made.
  std::unique_ptr<Child> makeChild() const;

  const Work work_;
  std::unique_ptr<Child> child_;
};

}  // namespace handover
