// SPDX-License-Identifier: Apache-2.0
// handoverctl: asks a handover daemon, prints what it answers.
#include "commands.hpp"
#include "state_obj.hpp"
#include "view/root_files.hpp"
#include "view/view.hpp"

#include <handover/client/client.hpp>
#include <handover/common/check.hpp>
#include <handover/common/domain.hpp>
#include <handover/common/log.hpp>
#include <handover/common/standard_streams.hpp>

#include <CLI/CLI.hpp>

#include <charconv>
#include <cmath>
#include <iostream>
#include <sstream>

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

/// Entries of `A[/arm],B[/arm],...` or `auto`.
std::vector<std::string> chainOf(const std::string& text) {
  std::vector<std::string> chain;
  std::istringstream in(text + ",");
  for (std::string entry; std::getline(in, entry, ',');) chain.push_back(entry);
  return chain;
}

std::string checkChain(const std::string& text) {
  const std::vector<std::string> chain = chainOf(text);
  if (chain == std::vector<std::string>{kAutoChain}) return "";
  if (chain.size() > bounds::kHolders) return "has more than 8 holders";
  for (const std::string& entry : chain) {
    if (entry == kAutoChain) return "auto must stand alone";
    if (!holderOf(entry)) return "'" + entry + "' is not ROBOT or ROBOT/ARM";
  }
  return "";
}

/// A CLI11 check for the name of an enumerator.
template <NamedEnum Enum>
CLI::Validator nameOf(const std::string& what) {
  return CLI::Validator(
      [what](const std::string& text) -> std::string {
        if (fromString<Enum>(text)) return "";
        std::string known;
        for (std::size_t i = 1; i < EnumNames<Enum>::value.size(); ++i) {
          known += (i == 1 ? "" : ", ") + std::string(EnumNames<Enum>::value[i]);
        }
        return "unknown " + what + " '" + text + "'; it is one of " + known;
      },
      "");
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
  std::string mode = "best", search = "wide", objective;
  double deadline_s = 0;
  CLI::Option* deadline = nullptr;
};

void addSearch(CLI::App& app, SearchFlags& flags) {
  app.add_option("--mode", flags.mode, "first: the first plan; best: better ones after it; all")
      ->check(nameOf<SearchMode>("mode"))
      ->type_name("MODE")
      ->capture_default_str();
  app.add_option("--search", flags.search, "paper: the paper's candidates; wide: more after them")
      ->check(nameOf<SearchWidth>("search"))
      ->type_name("SEARCH")
      ->capture_default_str();
  app.add_option("--objective", flags.objective,
                 "What plans are the best at: balanced, time, dexterity (default: the task's)")
      ->check(nameOf<Objective>("objective"))
      ->type_name("OBJECTIVE");
  flags.deadline = app.add_option("--deadline", flags.deadline_s,
                                  "Time that a search may take\n"
                                  "(default: the daemon's limits.deadline_s, 1800 as shipped)")
                       ->check(numberWhere([](double v) { return v > 0; }, "above 0"))
                       ->type_name("SECONDS");
}

void setSearch(const SearchFlags& flags, PlanRequest& request) {
  request.mode = fromString<SearchMode>(flags.mode).value_or(SearchMode::kBest);
  request.search = fromString<SearchWidth>(flags.search).value_or(SearchWidth::kWide);
  request.objective = fromString<Objective>(flags.objective).value_or(Objective::kUnspecified);
  if (flags.deadline->count() > 0) request.deadline_s = flags.deadline_s;
}

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 internal error, 2 usage or unreadable input, 3 configuration or output "
    "not\nwritable, 4 DDS, 10 no plan, 11 cancelled or deadline without a plan, 12 rejected, 13 no "
    "daemon.";

/// Every help text ends with an example and the exit codes.
void addFooter(CLI::App& app, const std::string& example) {
  app.footer("Example: " + example + "\n" + kExitCodes);
}

struct PlanFlags {
  PlanOptions options;
  SearchFlags search;
  std::string chain, root;
  std::vector<std::string> set;
  std::vector<std::pair<std::string, std::string>> dumps;  ///< kind, file
  bool no_fix = false;
};

void addPlanFiles(CLI::App& app, PlanFlags& flags) {
  app.add_option("--output", flags.options.output, "Write the plan file, a failure's too")
      ->check(checkNotEmpty)
      ->type_name("FILE");
  app.add_option("--html", flags.options.html, "Write a page that shows the plan or the failure")
      ->check(checkNotEmpty)
      ->type_name("FILE");
  app.add_option(
         "--dump-state", flags.dumps,
         "Write the cell at start or end, or at the end of a stage (its index, or ACTION.HOLDER as "
         "grasp.1), as a Wavefront OBJ: collision shapes in the world, a group each; may repeat")
      ->type_name("KIND FILE")
      ->allow_extra_args(false);
  app.add_option("--root", flags.root,
                 "Folder that the plan's paths are relative to, for --dump-state and --html "
                 "(default: HANDOVER_ROOT, else the installed share, else the repository)")
      ->type_name("DIR");
}

void addPlan(CLI::App& app, PlanFlags& flags) {
  PlanRequest& request = flags.options.request;
  app.add_option("--cell", request.cell, "Cell to plan in; required")->type_name("CELL");
  app.add_option("--task", request.task, "Task of the cell (default: its first)")
      ->type_name("TASK");
  app.add_option("--chain", flags.chain,
                 "Holders in order, A[/arm],B[/arm],..., or auto (default: the task's)")
      ->check(checkChain)
      ->type_name("CHAIN");
  app.add_option("--set", flags.set, "Change the cell for this request; may repeat")
      ->allow_extra_args(false)
      ->check(checkOverride)
      ->type_name("PATH=VALUE");
  addSearch(app, flags.search);
  app.add_option("--seed", request.seed, "Same scene, request and seed: same plan")
      ->check(checkSeed)
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_option("--speed", request.speed_scale, "Slows the motion, in (0, 1]")
      ->check(numberWhere([](double v) { return v > 0 && v <= 1; }, "in (0, 1]"))
      ->type_name("SCALE")
      ->capture_default_str();
  app.add_option("--slack", request.slack_s, "Lateness of each stage that the plan tolerates")
      ->check(numberWhere([](double v) { return v >= 0 && v <= bounds::kSlack; }, "in [0, 10]"))
      ->type_name("SECONDS")
      ->capture_default_str();
  app.add_flag("--no-fix", flags.no_fix, "Do not look for what would help a failed request");
  addPlanFiles(app, flags);
  addFooter(app, "handoverctl plan --cell butler --chain crichton,hubo/left --html plan.html");
}

PlanOptions finish(const PlanFlags& flags) {
  PlanOptions options = flags.options;
  if (options.request.cell.empty()) throw CLI::RequiredError("--cell");
  for (const auto& [kind, file] : flags.dumps) {
    if (!namesState(kind)) {
      throw CLI::ValidationError("--dump-state",
                                 "'" + kind + "' is not start, end, INDEX or ACTION.HOLDER");
    }
    if (file.empty()) throw CLI::ValidationError("--dump-state", "FILE is empty");
    options.dumps.push_back({kind, file});
  }
  options.root = flags.root.empty() ? view::defaultRoot() : std::filesystem::path(flags.root);
  if ((!options.dumps.empty() || !options.html.empty()) && options.root.empty()) {
    throw CLI::ValidationError("--root",
                               "is needed: neither an installed share nor the repository is here");
  }
  PlanRequest& request = options.request;
  if (!flags.chain.empty()) request.chain = chainOf(flags.chain);
  for (const auto& text : flags.set) request.overrides.push_back(overrideOf(text));
  request.wants_fix = !flags.no_fix;
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
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_option("--seed", options.request.seed,
                 "Of the draws; run i sends its request with this seed plus i")
      ->check(checkSeed)
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_option("--jobs", options.jobs, "Requests in flight at once")
      ->check(CLI::Range(1, 64))
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_option("--stretch", options.stretch, "Scales the ranges about their middles")
      ->check(numberWhere([](double v) { return v >= 0 && v <= 100; }, "in [0, 100]"))
      ->type_name("SCALE")
      ->capture_default_str();
  app.add_option("--task", options.request.task, "Task of the cell (default: its first)")
      ->type_name("TASK");
  addSearch(app, flags.search);
  app.add_option("--root", options.root,
                 "Folder that plans' paths are relative to, for --verify and --html (default: "
                 "HANDOVER_ROOT, else the installed share, else the repository)")
      ->type_name("DIR");
  app.add_option("--output", options.output, "Write the experiment file")
      ->check(checkNotEmpty)
      ->type_name("FILE");
  app.add_option("--plans", options.plans,
                 "Write plans, and failures, to this folder, NNN.json by run")
      ->check(checkNotEmpty)
      ->type_name("DIR");
  app.add_flag("--verify", options.verify, "Have handover-verify check every plan");
  app.add_option("--html", options.html,
                 "Write a page that shows the experiment, and beside it one of its failures")
      ->check(checkNotEmpty)
      ->type_name("FILE");
  addFooter(app, "handoverctl experiment butler --runs 100 --mode first --html report.html");
}

std::string checkView(const std::string& text) {
  return view::knowsFormat(text) ? "" : "must end in .html or .mcap";
}

void addView(CLI::App& app, ViewOptions& options) {
  app.add_option("INPUT", options.plan, "Plan file, or cell file (.yaml)")
      ->required()
      ->check(checkNotEmpty);
  app.add_option("-o,--output", options.output, "A page (.html) or a recording (.mcap)")
      ->required()
      ->check(checkView)
      ->type_name("FILE");
  app.add_option("--root", options.root,
                 "Folder that paths are relative to (default: HANDOVER_ROOT, else the installed "
                 "share, else the repository)")
      ->type_name("DIR");
  addFooter(app, "handoverctl view plan.json -o plan.html");
}

int notBuiltYet(const std::string& what) {
  std::cerr << "handoverctl: not built yet: " << what << std::endl;
  return kExitConfiguration;
}

/// What of the search is not there yet; empty: all is.
std::string notBuilt(const PlanRequest& request) {
  return request.slack_s > 0 ? "--slack above 0" : "";
}

/// The program's command line; what it parses into stands beside it.
struct Command {
  CLI::App app{"Asks a handover daemon for plans.", "handoverctl"};
  CommonOptions common;
  std::string domain, id;
  double wait_s = 5;
  PlanFlags plan_flags;
  ExperimentFlags experiment_flags;
  ViewOptions view_options;
  CLI::App *status = nullptr, *cells = nullptr, *plan = nullptr, *watch = nullptr,
           *cancel = nullptr, *experiment = nullptr, *view = nullptr;

  Command() {
    app.set_version_flag("--version", version());
    app.fallthrough();
    app.add_option("--domain", domain, "DDS domain (default: HANDOVER_DOMAIN, else 0)")
        ->check(checkDomain)
        ->type_name("NUMBER");
    app.add_option("--wait", wait_s, "How long to wait for a daemon")
        ->check(numberWhere([](double v) { return v >= 0 && v < 1e6; }, "0 or more"))
        ->type_name("SECONDS")
        ->capture_default_str();
    app.add_flag("--json", common.json,
                 "JSON lines on standard output, all else on standard error");
    addFooter(app, "handoverctl plan --cell butler --html plan.html");
    addCommands();
  }

  static std::string version() { return std::string("handoverctl ") + HANDOVER_VERSION; }

 private:
  void addCommands() {
    status = app.add_subcommand("status", "Show the daemons");
    addFooter(*status, "handoverctl status --json");
    cells = app.add_subcommand("cells", "Show the cells that daemons serve");
    addFooter(*cells, "handoverctl cells");
    plan = app.add_subcommand("plan", "Plan a transport");
    addPlan(*plan, plan_flags);
    watch = app.add_subcommand("watch", "Show requests as they are answered");
    watch->add_option("ID", id, "Only this request; one that no daemon knows: exit code 2")
        ->check(checkId);
    addFooter(*watch, "handoverctl watch");
    cancel = app.add_subcommand("cancel", "Cancel a request");
    cancel->add_option("ID", id, "The request; one that no daemon knows: exit code 2")
        ->required()
        ->check(checkId);
    addFooter(*cancel, "handoverctl cancel 00112233445566778899aabbccddeeff");
    experiment = app.add_subcommand("experiment", "Plan many varied requests");
    addExperiment(*experiment, experiment_flags);
    view = app.add_subcommand("view", "Show a plan file: a page (.html) or a recording (.mcap)");
    addView(*view, view_options);
    addLater("scene", "Show or change a live scene", "scene show --cell butler");
    addLater("export", "Write trajectories for controllers",
             "export plan.json --format ros-json -o trajectories");
    addLater("record", "Record requests and answers", "record requests.rec");
    addLater("replay", "Ask recorded requests again", "replay requests.rec");
  }

  /// Takes any arguments: what they will mean is not asked yet.
  void addLater(const std::string& name, const std::string& what, const std::string& example) {
    CLI::App* later = app.add_subcommand(name, what + " (not built yet)");
    addFooter(*later, "handoverctl " + example);
    later->fallthrough(false)->allow_extras();
    later->set_version_flag("--version", version());
  }
};

int runParsed(Command& command, const PlanOptions& plan_options) {
  CommonOptions& common = command.common;
  common.domain = *parseDomain(command.domain);
  common.wait = std::chrono::milliseconds(std::llround(command.wait_s * 1e3));
  const std::optional<RequestId> request = RequestId::fromHex(command.id);
  if (command.status->parsed()) return runStatus(common);
  if (command.cells->parsed()) return runCells(common);
  if (command.watch->parsed()) return runWatch(common, request);
  if (command.cancel->parsed()) return runCancel(common, *request);
  if (command.plan->parsed()) {
    const std::string missing = notBuilt(plan_options.request);
    return missing.empty() ? runPlan(common, plan_options) : notBuiltYet(missing);
  }
  if (command.view->parsed()) {
    const auto kind = std::filesystem::path(command.view_options.plan).extension();
    if (kind == ".yaml" || kind == ".yml") return notBuiltYet("view of a cell file");
    return runView(common, command.view_options);
  }
  if (command.experiment->parsed()) {
    ExperimentFlags& flags = command.experiment_flags;
    setSearch(flags.search, flags.options.request);
    const std::string missing = notBuilt(flags.options.request);
    return missing.empty() ? runExperiment(common, flags.options) : notBuiltYet(missing);
  }
  return notBuiltYet(command.app.get_subcommands().front()->get_name());
}

int run(int argc, char** argv) {
  Command command;
  PlanOptions plan_options;
  try {
    command.app.parse(argc, argv);
    if (command.app.get_subcommands().empty()) throw CLI::RequiredError("A command");
    if (command.domain.empty()) {
      command.domain = environmentDomain().value_or("0");
      if (!parseDomain(command.domain)) {
        throw CLI::ValidationError("HANDOVER_DOMAIN", checkDomain(command.domain));
      }
    }
    if (command.plan->parsed()) plan_options = finish(command.plan_flags);
  } catch (const CLI::ParseError& error) {
    return command.app.exit(error) == 0 ? kExitDone : kExitUsage;
  }
  return runParsed(command, plan_options);
}

}  // namespace
}  // namespace handover::ctl

int main(int argc, char** argv) {
  try {
    handover::holdStandardStreams();
    handover::setLogLevel(spdlog::level::warn);
    handover::client::routeMiddlewareLog();
    return handover::checkedOutput("handoverctl", handover::ctl::run(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "handoverctl: " << error.what() << std::endl;
    return handover::kExitInternal;
  }
}
