// SPDX-License-Identifier: Apache-2.0
// What a bench found: rows of ours beside a reference, as a table for people and as JSON.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace handover::bench {

struct Row {
  std::string name;
  double ours = 0, reference = 0;
  std::string reference_name;
  std::string unit;  ///< "s", "us", "ns": less is better; "%": a success rate

  double ratio() const { return reference / ours; }
};

struct Report {
  std::vector<Row> rows;
  std::vector<std::string> notes;  ///< what a reader must know of the rows, a sentence each

  void add(const Report& other);
};

/// The machine (processor, cores, load) and the build, a few lines.
std::string machine();

void printTable(std::ostream& out, const Report& report);

/// [{"name", "ours", "reference", "reference_name", "ratio", "unit"}]
std::string json(const Report& report);

}  // namespace handover::bench
