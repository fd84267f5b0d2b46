// SPDX-License-Identifier: Apache-2.0
// handover-verify: an independent check of a plan file.
#include "verify/root.hpp"
#include "verify/unreadable.hpp"
#include "verify/verifier.hpp"

#include <CLI/CLI.hpp>

#include <csignal>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>

namespace {

namespace fs = std::filesystem;

constexpr int kValid = 0;
constexpr int kInvalid = 1;
constexpr int kUnreadable = 2;
constexpr int kOutputNotWritable = 3;

int unreadable(const std::string& what, bool json) {
  if (json) std::cout << handover::verify::unreadableJson(what) << "\n";
  std::cerr << "unreadable: " << what << "\n";
  return kUnreadable;
}

int run(int argc, char** argv) {
  CLI::App app{"Checks a handover plan file on its own: 0 valid, 1 invalid, 2 unreadable"};
  app.name("handover-verify");
  std::string plan, root;
  bool json = false;
  app.add_option("plan", plan, "plan file")->required();
  app.add_option("--root", root,
                 "folder that the plan's paths are relative to (default: HANDOVER_ROOT, else the "
                 "installed share, else the repository)");
  app.add_flag("--json", json, "one JSON object on standard output");
  app.footer(
      "Example: handover-verify plan.json --root /usr/share/handover\n"
      "Exit codes: 0 valid, 1 invalid (a line for each violation), 2 unreadable or without a "
      "plan,\n"
      "3 standard output cannot be written");
  app.set_version_flag("--version", std::string("handover-verify ") + HANDOVER_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kValid : kUnreadable;
  }
  try {
    const fs::path folder = root.empty() ? handover::verify::defaultRoot() : fs::path(root);
    if (folder.empty()) {
      return unreadable("neither an installed share nor the repository found: give --root", json);
    }
    const handover::verify::Report report = handover::verify::verifyPlan(plan, folder, json);
    if (json) {
      std::cout << handover::verify::toJson(report) << "\n";
    } else if (report.valid()) {
      std::cout << "valid\n";
    } else {
      std::cout << handover::verify::toText(report);
      std::cout << "invalid: " << report.violations.size() << " violation(s)\n";
    }
    return report.valid() ? kValid : kInvalid;
  } catch (const std::exception& error) {
    return unreadable(error.what(), json);
  }
}

/// A verdict that nobody could read is none.
int checkedOutput(int code) {
  std::cout.flush();
  if (std::cout || code != kValid) return code;
  std::cerr << "handover-verify: cannot write to standard output\n";
  return kOutputNotWritable;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  return checkedOutput(run(argc, argv));
}
