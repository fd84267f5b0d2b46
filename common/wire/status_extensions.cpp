// SPDX-License-Identifier: Apache-2.0
#include "wire/status_extensions.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

namespace handover::wire {
namespace {

/// Items of a list that one value holds, so that it stays below its bound.
constexpr std::size_t kItemsPerValue = 64;

using Extensions = std::vector<msg::KeyValue>;

void add(Extensions& extensions, const std::string& key, std::string value) {
  msg::KeyValue& item = extensions.emplace_back();
  item.key(key);
  item.value(std::move(value));
}

template <typename Number>
std::string decimal(Number number) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof(text), number).ptr};
}

/// The first `count` items, as key.0, key.1, ...
template <typename TextOf>
void addList(Extensions& extensions, const std::string& key, std::size_t count, TextOf text_of) {
  for (std::size_t first = 0; first < count; first += kItemsPerValue) {
    std::string value;
    for (std::size_t i = first; i < std::min(count, first + kItemsPerValue); ++i) {
      value += (i == first ? "" : ",") + text_of(i);
    }
    add(extensions, key + "." + std::to_string(first / kItemsPerValue), std::move(value));
  }
}

std::string textOf(const CellInfo& cell) {
  const bool led = cell.role == CellRole::kLeader || cell.role == CellRole::kStandby;
  return std::string(toString(cell.role)) + (led ? " " + decimal(cell.epoch) : "");
}

const std::string* find(const Extensions& extensions, std::string_view key) {
  const auto found = std::find_if(extensions.begin(), extensions.end(),
                                  [&](const auto& item) { return item.key() == key; });
  return found == extensions.end() ? nullptr : &found->value();
}

template <typename Number>
std::optional<Number> numberIn(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

template <typename Number>
std::optional<Number> number(const Extensions& extensions, std::string_view key) {
  const std::string* text = find(extensions, key);
  return text == nullptr ? std::nullopt : numberIn<Number>(*text);
}

/// Not negative and finite, as times are.
std::optional<double> time(const Extensions& extensions, std::string_view key) {
  const auto found = number<double>(extensions, key);
  return found && std::isfinite(*found) && *found >= 0 ? found : std::nullopt;
}

std::vector<std::string_view> list(const Extensions& extensions, const std::string& key) {
  std::vector<std::string_view> items;
  for (std::size_t i = 0;; ++i) {
    const std::string* value = find(extensions, key + "." + std::to_string(i));
    if (value == nullptr) return items;
    std::string_view rest = *value;
    for (auto comma = rest.find(','); comma != rest.npos; comma = rest.find(',')) {
      items.push_back(rest.substr(0, comma));
      rest.remove_prefix(comma + 1);
    }
    items.push_back(rest);
  }
}

void takeRole(std::string_view text, CellInfo& cell) {
  const auto blank = std::min(text.find(' '), text.size());
  const auto& names = EnumNames<CellRole>::value;
  const auto name = std::find(names.begin(), names.end(), text.substr(0, blank));
  if (name == names.end()) return;
  cell.role = static_cast<CellRole>(name - names.begin());
  if (blank == text.size()) return;
  cell.epoch = numberIn<std::uint32_t>(text.substr(blank + 1)).value_or(0);
}

}  // namespace

std::vector<msg::KeyValue> extensionsOf(const DaemonStatus& status) {
  Extensions out;
  add(out, "dropped_packets", decimal(status.dropped_packets));
  add(out, "uptime_s", decimal(status.uptime_s));
  if (status.answer_times) {
    add(out, "answer_ms_median", decimal(status.answer_times->median_ms));
    add(out, "answer_ms_p95", decimal(status.answer_times->p95_ms));
  }
  add(out, "kept_requests", decimal(status.kept_requests));
  addList(out, "roles", status.cells.size(),
          [&](std::size_t i) { return textOf(status.cells[i]); });
  addList(out, "answered", std::min(status.answered.size(), kMostAnswered),
          [&](std::size_t i) { return status.answered[i].hex(); });
  return out;
}

void takeExtensions(const Extensions& extensions, DaemonStatus& status) {
  status.dropped_packets = number<std::uint64_t>(extensions, "dropped_packets").value_or(0);
  status.uptime_s = time(extensions, "uptime_s").value_or(0);
  const auto median = time(extensions, "answer_ms_median"), p95 = time(extensions, "answer_ms_p95");
  if (median && p95) status.answer_times = AnswerTimes{*median, *p95};
  status.kept_requests = number<std::uint32_t>(extensions, "kept_requests").value_or(0);
  const auto roles = list(extensions, "roles");
  for (std::size_t i = 0; i < std::min(roles.size(), status.cells.size()); ++i) {
    takeRole(roles[i], status.cells[i]);
  }
  for (const std::string_view id : list(extensions, "answered")) {
    if (const auto read = RequestId::fromHex(id)) status.answered.push_back(*read);
  }
}

}  // namespace handover::wire
