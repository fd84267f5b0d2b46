// SPDX-License-Identifier: Apache-2.0
#include "failure_page.hpp"

#include "output_file.hpp"
#include "view/page.hpp"
#include "view/root_files.hpp"

#include <handover/client/plan_file.hpp>

#include <iterator>

namespace handover::ctl {
namespace {

namespace fs = std::filesystem;

std::string nameOf(std::uint64_t run) { return "run-" + std::to_string(run); }

/// One segment of an address.
std::string escaped(const std::string& name) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string text;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain =
        std::isalnum(byte) != 0 || std::string_view("-_.~").find(c) != std::string_view::npos;
    if (plain) {
      text += c;
    } else {
      text += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return text;
}

}  // namespace

FailurePage::FailurePage(const fs::path& report) : path_(report) {
  path_.replace_extension(".failures.html");
}

void FailurePage::add(std::uint64_t run, std::string plan_text) {
  runs_.insert_or_assign(run, std::move(plan_text));
  if (runs_.size() > kMost) runs_.erase(std::prev(runs_.end()));
}

bool FailurePage::write(const fs::path& root) const {
  std::error_code ignored;
  fs::remove(path_, ignored);
  if (runs_.empty()) return true;
  const fs::path folder = root.empty() ? view::defaultRoot() : root;
  if (folder.empty()) {
    throw client::PlanFileError("--root", "neither an installed share nor the repository found");
  }
  std::vector<view::NamedPlan> plans;
  for (const auto& [run, text] : runs_) plans.push_back({nameOf(run), text});
  const std::string page = view::failuresPage(plans, folder);
  OutputFile file(path_);
  return file.writable() && file.commit(page);
}

std::string FailurePage::linkTo(std::uint64_t run) const {
  return runs_.contains(run) ? escaped(path_.filename().string()) + "#" + nameOf(run) : "";
}

}  // namespace handover::ctl
