// SPDX-License-Identifier: Apache-2.0
// handoverctl: asks a handover daemon, prints what it answers.
#include "commands.hpp"
#include "verify/root.hpp"
#include "verify/state_obj.hpp"
#include "view/view.hpp"

#include <handover/client/client.hpp>
#include <handover/common/domain.hpp>
#include <handover/common/log.hpp>

#include <CLI/CLI.hpp>

#include <charconv>
#include <cmath>
#include <iostream>

namespace handover::ctl {
namespace {

std::string checkDomain(const std::string& text) {
  return parseDomain(text) ? "" : "must be a number from 0 to 232";
}

/// A CLI11 check for a finite number that fulfils a condition.
CLI::Validator numberWhere(std::function<bool(double)> condition, const std::string& what) {
  return CLI::Validator(
      [condition = std::move(condition), what](const std::string& text) -> std::string {
        double value = 0;
        const bool number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
        return number && condition(value) ? "" : "must be " + what;
      },
      "");
}

/// CLI11 would take -1, and what is beyond the largest number, for the largest number.
std::string checkSeed(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = code == std::errc() && end == text.data() + text.size();
  return whole ? "" : "must be a number from 0 to 18446744073709551615";
}

std::string checkNotEmpty(const std::string& text) { return text.empty() ? "is empty" : ""; }

std::string checkId(const std::string& text) {
  return RequestId::fromHex(text) ? "" : "must be 32 hex digits";
}

std::string checkOverride(const std::string& text) {
  const auto equals = text.find('=');
  return equals == std::string::npos || equals == 0 ? "must be PATH=VALUE" : "";
}

Override overrideOf(const std::string& text) {
  const auto equals = text.find('=');
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// How requests are searched: what `plan` and `experiment` share.
struct SearchFlags {
  std::string mode = "best", search = "wide";
};

void addSearch(CLI::App& app, SearchFlags& flags) {
  app.add_option("--mode", flags.mode, "Stop at the first plan, take the best, or try all")
      ->check(CLI::IsMember({"first", "best", "all"}))
      ->capture_default_str();
  app.add_option("--search", flags.search, "The paper's candidates, or more after them")
      ->check(CLI::IsMember({"paper", "wide"}))
      ->capture_default_str();
}

void setSearch(const SearchFlags& flags, PlanRequest& request) {
  request.mode = flags.mode == "first" ? SearchMode::kFirst
                 : flags.mode == "all" ? SearchMode::kAll
                                       : SearchMode::kBest;
  request.search = flags.search == "paper" ? SearchWidth::kPaper : SearchWidth::kWide;
}

struct PlanFlags {
  PlanOptions options;
  SearchFlags search;
  std::vector<std::string> set;
  std::vector<std::pair<std::string, std::string>> dumps;  ///< kind, file
  std::string root;
  double deadline_s = 0;
  CLI::Option* deadline = nullptr;
};

void addPlan(CLI::App& app, PlanFlags& flags) {
  PlanRequest& request = flags.options.request;
  app.add_option("--cell", request.cell, "Cell to plan in")->required();
  app.add_option("--task", request.task, "Task of the cell (default: its first)");
  app.add_option("--set", flags.set, "Change the cell for this request, PATH=VALUE; may repeat")
      ->allow_extra_args(false)
      ->check(checkOverride);
  app.add_option("--giver-arm", request.giver_arm, "Arm of the giver (default: free choice)");
  app.add_option("--receiver-arm", request.receiver_arm, "Arm of the receiver (default: free)");
  addSearch(app, flags.search);
  app.add_option("--seed", request.seed, "Same scene, request and seed: same plan")
      ->check(checkSeed)
      ->capture_default_str();
  flags.deadline = app.add_option("--deadline", flags.deadline_s, "Seconds the daemon may take")
                       ->check(numberWhere([](double v) { return v > 0; }, "above 0"));
  app.add_option("--speed", request.speed_scale, "Slows the motion, in (0, 1]")
      ->check(numberWhere([](double v) { return v > 0 && v <= 1; }, "in (0, 1]"))
      ->capture_default_str();
  app.add_option("--output", flags.options.output, "Write the plan file here")
      ->check(checkNotEmpty);
  app.add_option(
         "--dump-state", flags.dumps,
         "Write the cell at the end of stage KIND (giver_grasp ...), or at start or end, as a "
         "Wavefront OBJ: collision shapes in the world, a group each; may repeat")
      ->type_name("KIND FILE")
      ->allow_extra_args(false);
  app.add_option(
      "--root", flags.root,
      "Folder that the plan's paths are relative to, for --dump-state and --html (default: "
      "the installed share, else the repository)");
  app.add_option("--html", flags.options.html, "Write a page that shows the plan")
      ->check(checkNotEmpty);
}

PlanOptions finish(const PlanFlags& flags) {
  PlanOptions options = flags.options;
  for (const auto& [kind, file] : flags.dumps) {
    if (!verify::namesState(kind)) {
      throw CLI::ValidationError("--dump-state", "'" + kind + "' is no stage, nor start or end");
    }
    if (file.empty()) throw CLI::ValidationError("--dump-state", "FILE is empty");
    options.dumps.push_back({kind, file});
  }
  options.root = flags.root.empty() ? verify::defaultRoot() : std::filesystem::path(flags.root);
  if ((!options.dumps.empty() || !options.html.empty()) && options.root.empty()) {
    throw CLI::ValidationError("--root",
                               "is needed: neither an installed share nor the repository is here");
  }
  PlanRequest& request = options.request;
  for (const auto& text : flags.set) request.overrides.push_back(overrideOf(text));
  if (flags.deadline->count() > 0) request.deadline_s = flags.deadline_s;
  setSearch(flags.search, request);
  return options;
}

struct ExperimentFlags {
  ExperimentOptions options;
  SearchFlags search;
};

void addExperiment(CLI::App& app, ExperimentFlags& flags) {
  ExperimentOptions& options = flags.options;
  app.add_option("CELL", options.request.cell, "Cell whose variations are drawn")
      ->required()
      ->check(checkNotEmpty);
  app.add_option("--runs", options.runs, "How many draws are planned")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000}))
      ->capture_default_str();
  app.add_option("--seed", options.request.seed,
                 "Of the draws; run i sends its request with this seed plus i")
      ->check(checkSeed)
      ->capture_default_str();
  app.add_option("--jobs", options.jobs, "Requests in flight at once")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--stretch", options.stretch, "Scales the ranges about their middles")
      ->check(numberWhere([](double v) { return v >= 0 && v <= 100; }, "in [0, 100]"))
      ->capture_default_str();
  app.add_option("--task", options.request.task, "Task of the cell (default: its first)");
  addSearch(app, flags.search);
  app.add_option("--output", options.output, "Write the experiment file here")
      ->check(checkNotEmpty);
  app.add_option("--plans", options.plans, "Write the plans to this folder, NNN.json by run")
      ->check(checkNotEmpty);
  app.add_flag("--verify", options.verify, "Have handover-verify check every plan");
  app.add_option("--html", options.html, "Write a page that shows the experiment")
      ->check(checkNotEmpty);
}

std::string checkView(const std::string& text) {
  return view::knowsFormat(text) ? "" : "must end in .html or .mcap";
}

void addView(CLI::App& app, ViewOptions& options) {
  app.add_option("PLAN", options.plan, "Plan file")->required()->check(checkNotEmpty);
  app.add_option("-o,--output", options.output, "A page (.html) or a recording (.mcap)")
      ->required()
      ->check(checkView);
  app.add_option("--root", options.root,
                 "Folder that the plan's paths are relative to (default: the installed share, else "
                 "the repository)");
}

int notBuiltYet(const std::string& what) {
  std::cerr << "handoverctl: not built yet: " << what << std::endl;
  return kExitConfiguration;
}

int run(int argc, char** argv) {
  CLI::App app{"Asks a handover daemon for plans.", "handoverctl"};
  const std::string version = std::string("handoverctl ") + HANDOVER_VERSION;
  app.set_version_flag("--version", version);
  app.require_subcommand(1);
  app.fallthrough();

  CommonOptions common;
  std::string domain;
  double wait_s = 5;
  app.add_option("--domain", domain, "DDS domain (default: HANDOVER_DOMAIN, else 0)")
      ->check(checkDomain);
  app.add_option("--wait", wait_s, "Seconds to wait for a daemon")
      ->check(numberWhere([](double v) { return v >= 0 && v < 1e6; }, "0 or more"))
      ->capture_default_str();
  app.add_flag("--json", common.json, "JSON lines on standard output, all else on standard error");

  auto* status = app.add_subcommand("status", "Show the daemons");
  auto* cells = app.add_subcommand("cells", "Show the cells that daemons serve");
  auto* plan = app.add_subcommand("plan", "Plan a handover");
  PlanFlags flags;
  PlanOptions options;
  addPlan(*plan, flags);
  std::string id;
  auto* watch = app.add_subcommand("watch", "Show requests as they are answered");
  watch->add_option("ID", id, "Only this request")->check(checkId);
  auto* cancel = app.add_subcommand("cancel", "Cancel a request");
  cancel->add_option("ID", id, "The request")->required()->check(checkId);
  auto* scene = app.add_subcommand("scene", "Show or change a live scene");
  auto* experiment = app.add_subcommand("experiment", "Plan many varied requests");
  ExperimentFlags experiment_flags;
  addExperiment(*experiment, experiment_flags);
  auto* view =
      app.add_subcommand("view", "Show a plan file: a page (.html) or a recording (.mcap)");
  ViewOptions view_options;
  addView(*view, view_options);
  scene->fallthrough(false)->allow_extras();
  scene->set_version_flag("--version", version);

  try {
    app.parse(argc, argv);
    if (domain.empty()) {
      domain = environmentDomain().value_or("0");
      if (!parseDomain(domain)) {
        throw CLI::ValidationError("HANDOVER_DOMAIN", checkDomain(domain));
      }
    }
    if (plan->parsed()) options = finish(flags);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitDone : kExitUsage;
  }
  common.domain = *parseDomain(domain);
  common.wait = std::chrono::milliseconds(std::llround(wait_s * 1e3));

  const std::optional<RequestId> request = RequestId::fromHex(id);
  if (status->parsed()) return runStatus(common);
  if (cells->parsed()) return runCells(common);
  if (watch->parsed()) return runWatch(common, request);
  if (cancel->parsed()) return runCancel(common, *request);
  if (plan->parsed()) return runPlan(common, options);
  if (view->parsed()) return runView(common, view_options);
  if (experiment->parsed()) {
    setSearch(experiment_flags.search, experiment_flags.options.request);
    return runExperiment(common, experiment_flags.options);
  }
  return notBuiltYet(app.get_subcommands().front()->get_name());
}

}  // namespace
}  // namespace handover::ctl

int main(int argc, char** argv) {
  try {
    handover::setLogLevel(spdlog::level::warn);
    handover::client::routeMiddlewareLog();
    return handover::ctl::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "handoverctl: " << error.what() << std::endl;
    return handover::ctl::kExitInternal;
  }
}
