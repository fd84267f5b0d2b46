// SPDX-License-Identifier: Apache-2.0
// One logger per module tag, all writing to standard error: standard output belongs to answers.
// A line is UTC time, module, level and text, which is escaped wherever it comes from. Where
// standard error is systemd's journal, lines go there as entries with fields instead, and need no
// time.
#pragma once

#include <spdlog/spdlog.h>

#include <memory>
#include <string>
#include <vector>

namespace handover {

/// The logger of a module ("runtime", "dds", "maps"); made on first use. Safe from any thread.
std::shared_ptr<spdlog::logger> logger(const std::string& tag);

/// Sets the level of all loggers, present and future: trace, debug, info, warn, error, off.
void setLogLevel(spdlog::level::level_enum level);

/// What a journal keeps beside the text: a name as HANDOVER_CELL, and a value.
struct LogField {
  std::string name, value;
};

/// A line of the module; its fields are kept where there is a journal, so the text has them too.
void logWith(const std::string& tag, spdlog::level::level_enum level, const std::string& text,
             const std::vector<LogField>& fields);

/// An entry of systemd's journal as the native protocol wants it, a field a line; values escaped.
std::string journalEntry(const std::string& tag, spdlog::level::level_enum level,
                         const std::string& text, const std::vector<LogField>& fields);

/// Whether standard error goes to systemd's journal, as $JOURNAL_STREAM tells.
bool standardErrorIsJournal();

}  // namespace handover
