// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <ostream>
#include <thread>

namespace handover::bench {
namespace {

std::string firstLineAfter(const char* file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const auto value = line.find_first_not_of(" \t:", key.size());
    return value == std::string::npos ? "" : line.substr(value);
  }
  return "unknown";
}

std::string loadOfTheLastMinute() {
  std::string load;
  std::ifstream("/proc/loadavg") >> load;
  return load;
}

std::string compiler() {
#if defined(__clang__)
  return __VERSION__;
#else
  return std::string("GCC ") + __VERSION__;
#endif
}

/// Three significant digits, no exponent.
std::string number(double value) {
  const double size = std::abs(value);
  const int digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.1 ? 3 : 4;
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

}  // namespace

void Report::add(const Report& other) {
  rows.insert(rows.end(), other.rows.begin(), other.rows.end());
  notes.insert(notes.end(), other.notes.begin(), other.notes.end());
}

std::string machine() {
  std::string text = firstLineAfter("/proc/cpuinfo", "model name") + ", " +
                     std::to_string(std::thread::hardware_concurrency()) + " cores, load " +
                     loadOfTheLastMinute() + "\n" + compiler();
#ifdef NDEBUG
  text += ", release build";
#else
  text += ", NOT a release build: the figures mean nothing";
#endif
  return text;
}

void printTable(std::ostream& out, const Report& report) {
  std::size_t name_width = 4, reference_width = 9;
  for (const Row& row : report.rows) {
    name_width = std::max(name_width, row.name.size());
    reference_width = std::max(reference_width, row.reference_name.size());
  }
  const auto line = [&](const std::string& name, const std::string& ours,
                        const std::string& reference, const std::string& unit,
                        const std::string& ratio, const std::string& reference_name) {
    const auto left = [](std::string text, std::size_t width) {
      return text.append(width - std::min(width, text.size()), ' ');
    };
    const auto right = [](const std::string& text, std::size_t width) {
      return std::string(width - std::min(width, text.size()), ' ') + text;
    };
    out << left(name, name_width) << right(ours, 10) << right(reference, 11) << ' ' << left(unit, 3)
        << right(ratio, 8) << "  " << reference_name << '\n';
  };
  line("", "ours", "reference", "", "ratio", "reference is");
  for (const Row& row : report.rows) {
    line(row.name, number(row.ours), number(row.reference), row.unit, number(row.ratio()),
         row.reference_name);
  }
  out << "\nratio = reference / ours: above 1, ours is faster. Rows in % are success rates: there, "
         "below 1, ours succeeds more often.\n";
  for (const auto& note : report.notes) out << note << '\n';
}

std::string json(const Report& report) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Row& row : report.rows) {
    rows.push_back({{"name", row.name},
                    {"ours", row.ours},
                    {"reference", row.reference},
                    {"reference_name", row.reference_name},
                    {"ratio", row.ratio()},
                    {"unit", row.unit}});
  }
  return rows.dump(2) + "\n";
}

}  // namespace handover::bench
