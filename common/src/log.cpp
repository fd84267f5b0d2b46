// SPDX-License-Identifier: Apache-2.0
#include <handover/common/log.hpp>
#include <handover/common/printable.hpp>
#include <handover/common/unix_datagram.hpp>

#include <errno.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <mutex>

namespace handover {
namespace {

constexpr const char* kJournalSocket = "/run/systemd/journal/socket";

/// The text of a line, escaped.
class EscapedText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& line) override {
    const std::string text = printable({message.payload.data(), message.payload.size()});
    line.append(text.data(), text.data() + text.size());
  }

  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<EscapedText>();
  }
};

std::unique_ptr<spdlog::formatter> lineFormatter() {
  auto formatter = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  formatter->add_flag<EscapedText>('*').set_pattern("%Y-%m-%dT%H:%M:%S.%eZ [%n] [%l] %*");
  return formatter;
}

/// As syslog counts.
int priorityOf(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical:
      return 2;
    case spdlog::level::err:
      return 3;
    case spdlog::level::warn:
      return 4;
    case spdlog::level::info:
      return 6;
    default:
      return 7;
  }
}

/// Into the journal, and as plain text to standard error what it does not take.
class JournalSink : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string tag(message.logger_name.data(), message.logger_name.size());
    const std::string text(message.payload.data(), message.payload.size());
    const std::string entry = journalEntry(tag, message.level, text, {});
    if (!sendUnixDatagram(kJournalSocket, entry)) stderr_.log(message);
  }

  void flush_() override {}

  void set_formatter_(std::unique_ptr<spdlog::formatter> formatter) override {
    stderr_.set_formatter(std::move(formatter));
  }

  spdlog::sinks::stderr_sink_mt stderr_;
};

const spdlog::sink_ptr& theSink() {
  static const spdlog::sink_ptr sink = [] {
    spdlog::sink_ptr made = std::make_shared<spdlog::sinks::stderr_sink_mt>();
    if (standardErrorIsJournal()) made = std::make_shared<JournalSink>();
    made->set_formatter(lineFormatter());
    return made;
  }();
  return sink;
}

std::mutex& creationMutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::shared_ptr<spdlog::logger> logger(const std::string& tag) {
  const std::lock_guard lock(creationMutex());
  if (auto known = spdlog::get(tag)) return known;
  auto made = std::make_shared<spdlog::logger>(tag, theSink());
  made->set_level(spdlog::get_level());
  spdlog::register_logger(made);
  return made;
}

void setLogLevel(spdlog::level::level_enum level) { spdlog::set_level(level); }

void logWith(const std::string& tag, spdlog::level::level_enum level, const std::string& text,
             const std::vector<LogField>& fields) {
  const auto to = logger(tag);
  if (!to->should_log(level)) return;
  const bool kept = !fields.empty() && standardErrorIsJournal() &&
                    sendUnixDatagram(kJournalSocket, journalEntry(tag, level, text, fields));
  if (!kept) to->log(level, "{}", text);
}

std::string journalEntry(const std::string& tag, spdlog::level::level_enum level,
                         const std::string& text, const std::vector<LogField>& fields) {
  std::string entry = "MESSAGE=[" + printable(tag) + "] " + printable(text) +
                      "\nPRIORITY=" + std::to_string(priorityOf(level)) +
                      "\nSYSLOG_IDENTIFIER=" + program_invocation_short_name +
                      "\nHANDOVER_MODULE=" + printable(tag) + "\n";
  for (const LogField& field : fields) entry += field.name + "=" + printable(field.value) + "\n";
  return entry;
}

bool standardErrorIsJournal() {
  static const bool is = [] {
    const char* stream = std::getenv("JOURNAL_STREAM");
    struct stat stderr_is {};
    if (stream == nullptr || ::fstat(STDERR_FILENO, &stderr_is) != 0) return false;
    return stream == std::to_string(stderr_is.st_dev) + ":" + std::to_string(stderr_is.st_ino);
  }();
  return is;
}

}  // namespace handover
