// SPDX-License-Identifier: Apache-2.0
// handoverd: answers handover requests over DDS.
//
// Threads (name: loop; waits for; stopped by):
//   main       start-up, then reloads; a signal or a failed preparation; itself
//   signals    sigwait; a signal; ~DaemonSignals
//   prepare    builds what is missing, ends; files and processors; Runtime::stop()
//   worker-N   takes a request, plans; the queue; Runtime::stop()
//   lead       claims cells, follows other daemons' claims; claims and time; Runtime::stop()
//   status     reports changes, expires queued deadlines; changes and time; Runtime::stop()
//   send-N     writes events, makes and deletes their writers; what is to be sent; ~DdsEndpoint
//   probe      asks the daemon from outside every two seconds; an answer; runDaemon()
//   (Fast DDS) receive, discovery, timers; the network; ~DdsEndpoint. They decode, enqueue and
//              return.
#include "cells/cell_service.hpp"
#include "cells/decomposition_cache.hpp"
#include "cells/scene_check.hpp"
#include "daemon.hpp"
#include "runtime/memory.hpp"
#include "settings/check.hpp"
#include "settings/roots.hpp"
#include "settings/settings_file.hpp"
#include "settings/yaml_reader.hpp"
#include "wire/entities.hpp"

#include <handover/common/domain.hpp>
#include <handover/common/exit_code.hpp>
#include <handover/common/log.hpp>
#include <handover/common/mutex.hpp>
#include <handover/common/standard_streams.hpp>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace handover {
namespace {

struct Options {
  std::vector<std::string> cells;
  std::vector<std::string> files;
  std::string config, domain, root;
  std::optional<int> threads;
  bool force = false, scene = false, json = false;
};

/// The settings file with what the command line says over it.
struct Setup {
  std::filesystem::path root;
  DaemonSettings settings;
};

Setup setUp(const Options& options) {
  Setup setup;
  setup.root = findRoot(options.root);
  const auto standard = setup.root / "config" / "handoverd.yaml";
  if (!options.config.empty()) {
    setup.settings = readDaemonSettings(options.config);
  } else if (std::filesystem::exists(standard)) {
    setup.settings = readDaemonSettings(standard);
  }
  if (!options.cells.empty()) setup.settings.cells = options.cells;
  if (options.threads) setup.settings.threads = *options.threads;
  if (!options.domain.empty()) setup.settings.domain = *parseDomain(options.domain);
  if (setup.settings.cells.empty()) {
    throw std::runtime_error("no cell: name one with --cell or in the settings file");
  }
  setLogLevel(spdlog::level::from_str(setup.settings.log_level));
  return setup;
}

/// Shows what is being prepared: a bar that is drawn over itself on a terminal, else a line a
/// product.
class ProgressBar {
 public:
  void operator()(const std::string& what, double fraction) {
    const MutexLock lock(mutex_);
    if (isatty(STDERR_FILENO) != 0) {
      const int filled = static_cast<int>(fraction * kWidth);
      std::cerr << "\r\033[K" << std::string(static_cast<std::size_t>(filled), '#')
                << std::string(static_cast<std::size_t>(kWidth - filled), '.') << ' '
                << static_cast<int>(fraction * 100) << " % " << what;
      if (fraction >= 1.0) std::cerr << '\n';
      std::cerr.flush();
    } else if (what != last_) {
      logger("prepare")->info("{}", what);
    }
    last_ = what;
  }

 private:
  static constexpr int kWidth = 30;
  Mutex mutex_;
  std::string last_ HANDOVER_GUARDED_BY(mutex_);
};

int notBuiltYet(const std::string& what) {
  std::cerr << "handoverd: not built yet: " << what << std::endl;
  return kExitConfiguration;
}

constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20;

CacheFolder cacheOf(const DaemonSettings& settings) {
  return {cacheFolder(settings.cache), kMebibyte * static_cast<std::uint64_t>(settings.cache_mib)};
}

/// What the settings say of requests and clients.
RuntimeSettings runtimeSettings(const DaemonSettings& settings) {
  const DaemonLimits& limits = settings.limits;
  RuntimeSettings runtime;
  runtime.threads = settings.threads;
  runtime.queue_capacity = static_cast<std::size_t>(limits.queue);
  runtime.client_queue = static_cast<std::size_t>(limits.client_queue);
  runtime.client_limits = {limits.client_cpu_s,
                           kMebibyte * static_cast<std::uint64_t>(limits.client_cache_mib)};
  runtime.sharing = settings.share_cells ? CellSharing::kShared : CellSharing::kStandby;
  if (limits.deadline_s > 0) runtime.deadline_s = limits.deadline_s;
  return runtime;
}

int serve(const Options& options) {
  boundAllocatorPools();
  const Setup setup = setUp(options);
  if (setup.settings.transport != "loopback") {
    return notBuiltYet("transport " + setup.settings.transport);
  }
  DaemonSignals signals;  // before the first thread
  ProgressBar bar;
  try {
    CellService service(setup.root, setup.settings.cells, cacheOf(setup.settings), std::ref(bar),
                        false, signals.stopping());
    const DaemonOptions daemon{.domain = setup.settings.domain,
                               .runtime = runtimeSettings(setup.settings)};
    return runDaemon(service, daemon, signals) ? kExitDone : kExitConfiguration;
  } catch (const std::exception&) {
    if (signals.stopping().over()) return kExitDone;  // told to stop before it served
    throw;
  }
}

int prepareFiles(const Options& options) {
  const Setup setup = setUp(options);
  ProgressBar bar;
  CellService service(setup.root, setup.settings.cells, cacheOf(setup.settings), std::ref(bar),
                      options.force);
  service.prepareAll(Deadline());
  return kExitDone;
}

/// Where parts of meshes are kept; nowhere without a home, which a check does not need.
std::filesystem::path partsFolder() {
  try {
    return cacheFolder("");
  } catch (const std::runtime_error&) {
    return {};
  }
}

/// Prints what a check found, a line each: faults and warnings to standard output, facts to
/// standard error; with --json everything to standard output, as JSON.
class CheckPrinter {
 public:
  explicit CheckPrinter(bool json) : json_(json) {}

  void print(SceneFinding::Grade grade, const FileFault& finding) const {
    using Grade = SceneFinding::Grade;
    const bool fact = grade == Grade::kFact;
    const char* word = fact ? "fact" : grade == Grade::kWarning ? "warning" : "fault";
    if (json_) {
      const nlohmann::ordered_json line{{"grade", word},
                                        {"file", finding.file},
                                        {"line", finding.line},
                                        {"message", finding.message}};
      const auto replace = nlohmann::json::error_handler_t::replace;
      std::cout << line.dump(-1, ' ', false, replace) << '\n';
      return;
    }
    FileFault shown = finding;
    if (grade == Grade::kWarning) shown.message = "warning: " + shown.message;
    (fact ? std::cerr : std::cout) << shown.text() << '\n';
  }

  void print(SceneFinding::Grade grade, const std::vector<FileFault>& findings) const {
    for (const FileFault& finding : findings) print(grade, finding);
  }

 private:
  bool json_;
};

/// Where a cell file describes a task; 0 where it does not say.
int lineOfTask(const YamlNode& document, const std::string& task) {
  const YamlNode* tasks = document.find("tasks");
  const YamlNode* found = tasks == nullptr ? nullptr : tasks->find(task);
  return found == nullptr ? 0 : found->line;
}

/// What touches, floats or is out of reach in cells. @return false: there are faults.
bool checkScenes(const Options& options, const std::filesystem::path& root,
                 const CheckPrinter& printer, ProgressBar& bar) {
  bool sound = true;
  for (const std::string& file : options.files) {
    CellService service(root, {file}, cacheFolder(""), std::ref(bar), false);
    const YamlNode document = parseYaml(readSettingsText(file), file);
    for (const auto& found :
         sceneFindings(service, service.served()->infos.front().name, Deadline())) {
      printer.print(found.grade, FileFault{file, lineOfTask(document, found.task),
                                           "task '" + found.task + "': " + found.text});
      sound = sound && found.grade != SceneFinding::Grade::kFault;
    }
  }
  return sound;
}

int checkEvery(const Options& options) {
  const std::vector<std::filesystem::path> files(options.files.begin(), options.files.end());
  const std::filesystem::path root = findRoot(options.root);
  ProgressBar bar;
  const DecompositionCache divide(partsFolder(), false, std::ref(bar));
  CheckReport report;
  divide.loadInRounds([&] {
    report = checkFiles(files, root, divide);
    return report.faults.empty();
  });
  const CheckPrinter printer(options.json);
  printer.print(SceneFinding::Grade::kFault, report.faults);
  printer.print(SceneFinding::Grade::kWarning, report.warnings);
  printer.print(SceneFinding::Grade::kFact, report.facts);
  if (!report.faults.empty()) return kExitConfiguration;
  if (options.scene && !checkScenes(options, root, printer, bar)) return kExitConfiguration;
  return kExitDone;
}

/// Every help text ends with an example and the exit codes.
void addFooter(CLI::App& app, const std::string& example, const std::string& exit_codes) {
  app.footer("Example: " + example + "\nExit codes: " + exit_codes);
}

constexpr const char* kStartCodes = "2 usage, 3 configuration";

std::string domainFault(const std::string& text) {
  return parseDomain(text) ? "" : "must be a number from 0 to 232";
}

void addCellOptions(CLI::App& command, Options& options) {
  command.add_option("--cell", options.cells, "Cell of config/cells, or file; may repeat")
      ->allow_extra_args(false)
      ->type_name("NAME|FILE");
  command
      .add_option("--root", options.root,
                  "Folder that holds config/ and robots/ (default: HANDOVER_ROOT, else the "
                  "installed share, else the repository)")
      ->type_name("DIR");
  command.add_option("--config", options.config, "Settings file (docs/operating.md)")
      ->type_name("FILE");
}

const CLI::App& addServe(CLI::App& app, Options& options) {
  auto& command = *app.add_subcommand(
      "serve", "Serve requests until SIGTERM or SIGINT; SIGHUP reads the cells again");
  addCellOptions(command, options);
  command.add_option("--domain", options.domain, "DDS domain (default: HANDOVER_DOMAIN, else 0)")
      ->check(domainFault)
      ->type_name("NUMBER");
  command.add_option("--threads", options.threads, "Requests planned at the same time, 1 to 64")
      ->check(CLI::Range(1, 64))
      ->type_name("NUMBER");
  addFooter(command, "handoverd serve --cell butler --domain 7",
            std::string("0 stopped by a signal, 1 internal error, ") + kStartCodes + ", 4 DDS.");
  return command;
}

void addPrepare(CLI::App& app, Options& options) {
  auto& command = *app.add_subcommand("prepare", "Build maps and grasp sets that are missing");
  addCellOptions(command, options);
  command.add_flag("--force", options.force, "Build all of them anew");
  addFooter(command, "handoverd prepare --cell butler --cell stool",
            std::string("0 all is there, 1 internal error, ") + kStartCodes + ".");
}

const CLI::App& addCheck(CLI::App& app, Options& options) {
  auto& command =
      *app.add_subcommand("check", "List every fault of cell, robot and settings files");
  command.add_option("FILE", options.files, "Files")->required()->type_name("FILE");
  command.add_option("--root", options.root, "Folder that holds config/ and robots/")
      ->type_name("DIR");
  command.add_flag("--scene", options.scene,
                   "Of cells too: what touches, floats, is out of reach; each hand's grasps");
  command.add_flag("--json", options.json, "A JSON object a line, on standard output");
  addFooter(command, "handoverd check config/cells/butler.yaml robots/hubo/hubo.yaml",
            "0 no faults (warnings too), 1 internal error, 2 usage, 3 faults (a line each).");
  return command;
}

/// The environment's where the command line names none.
void settleDomain(Options& options) {
  if (!options.domain.empty()) return;
  options.domain = environmentDomain().value_or("");
  if (!options.domain.empty() && !parseDomain(options.domain)) {
    throw CLI::ValidationError("HANDOVER_DOMAIN", domainFault(options.domain));
  }
}

int run(int argc, char** argv) {
  CLI::App app{"Answers handover requests over DDS.", "handoverd"};
  app.set_version_flag("--version", std::string("handoverd ") + HANDOVER_VERSION);
  app.require_subcommand(1);
  app.fallthrough();  // --version after a command
  addFooter(app, "handoverd serve --cell butler",
            std::string("0 done, 1 internal error, ") + kStartCodes + ", 4 DDS.");
  Options options;
  const CLI::App& serving = addServe(app, options);
  addPrepare(app, options);
  const CLI::App& check = addCheck(app, options);
  auto& adopt = *app.add_subcommand("adopt", "Make a robot of ours of a URDF (not built yet)");
  adopt.fallthrough(false)->allow_extras();
  try {
    app.parse(argc, argv);
    settleDomain(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitDone : kExitUsage;
  }
  if (serving.parsed()) return serve(options);
  DaemonSignals::leaveThem();
  if (adopt.parsed()) return notBuiltYet("adopt");
  if (check.parsed()) return checkEvery(options);
  return prepareFiles(options);
}

}  // namespace
}  // namespace handover

int main(int argc, char** argv) {
  try {
    handover::holdStandardStreams();
    return handover::checkedOutput("handoverd", handover::run(argc, argv));
  } catch (const handover::wire::DdsError& error) {
    std::cerr << "handoverd: " << error.what() << std::endl;
    return handover::kExitDds;
  } catch (const std::runtime_error& error) {
    std::cerr << "handoverd: " << error.what() << std::endl;
    return handover::kExitConfiguration;
  } catch (const std::exception& error) {
    std::cerr << "handoverd: " << error.what() << std::endl;
    return handover::kExitInternal;
  }
}
