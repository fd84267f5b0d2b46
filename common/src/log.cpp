// SPDX-License-Identifier: Apache-2.0
#include <handover/common/log.hpp>

#include <spdlog/sinks/stdout_sinks.h>

#include <mutex>

namespace handover {
namespace {

std::mutex& creationMutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::shared_ptr<spdlog::logger> logger(const std::string& tag) {
  const std::lock_guard lock(creationMutex());
  if (auto known = spdlog::get(tag)) return known;
  return spdlog::stderr_logger_mt(tag);
}

void setLogLevel(spdlog::level::level_enum level) { spdlog::set_level(level); }

}  // namespace handover
