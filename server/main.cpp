// SPDX-License-Identifier: Apache-2.0
// handoverd: answers handover requests over DDS.
//
// Threads (name: loop; waits for; stopped by):
//   main       start-up, then sigwait; a signal or a failed preparation; itself
//   prepare    builds what is missing, ends; files and processors; Runtime::stop()
//   worker-N   takes a request, plans; the queue; Runtime::stop()
//   status     reports changes, expires queued deadlines; changes and time; Runtime::stop()
//   to CLIENT  writes one client's stages; its queue and that client's acknowledgements;
//   ~DdsEndpoint (Fast DDS) receive, discovery, timers; the network; ~DdsEndpoint. They decode,
//   enqueue and return.
#include "daemon.hpp"
#include "listed_cells.hpp"
#include "wire/entities.hpp"

#include <handover/common/domain.hpp>
#include <handover/common/log.hpp>

#include <CLI/CLI.hpp>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <iostream>

namespace handover {
namespace {

enum ExitCode : int {
  kExitDone = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitConfiguration = 3,
  kExitDds = 4,
};

struct Options {
  std::vector<std::string> cells;
  std::vector<std::string> files;
  std::string config, domain, root;
  int threads = 1;
  bool force = false;
};

int serve(const Options& options, int domain) {
  const std::filesystem::path root =
      options.root.empty() ? std::filesystem::current_path() : std::filesystem::path(options.root);
  const StopSignals signals;  // before the first thread
  ListedCells service(root, options.cells);
  return runDaemon(service, {.domain = domain, .threads = options.threads}, signals)
             ? kExitDone
             : kExitConfiguration;
}

int notBuiltYet(const std::string& what) {
  std::cerr << "handoverd: not built yet: " << what << std::endl;
  return kExitConfiguration;
}

int run(int argc, char** argv) {
  CLI::App app{"Answers handover requests over DDS.", "handoverd"};
  app.set_version_flag("--version", std::string("handoverd ") + HANDOVER_VERSION);
  app.require_subcommand(1);
  Options options;
  const auto shared = [&options](CLI::App& command) {
    command.add_option("--cell", options.cells, "Cell of config/cells, or file; may repeat")
        ->allow_extra_args(false);
    command.add_option("--root", options.root, "Folder that holds config/ and robots/");
  };
  const auto check_domain = [](const std::string& text) -> std::string {
    return parseDomain(text) ? "" : "must be a number from 0 to 232";
  };
  auto* serve_command = app.add_subcommand("serve", "Serve requests until SIGTERM or SIGINT");
  shared(*serve_command);
  serve_command->add_option("--config", options.config, "Settings file");
  serve_command
      ->add_option("--domain", options.domain, "DDS domain (default: HANDOVER_DOMAIN, else 0)")
      ->check(check_domain);
  serve_command->add_option("--threads", options.threads, "Workers")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  auto* prepare = app.add_subcommand("prepare", "Build maps and grasp sets that are missing");
  shared(*prepare);
  prepare->add_flag("--force", options.force, "Build all of them anew");
  auto* check = app.add_subcommand("check", "List every fault of cell, robot and settings files");
  check->add_option("FILE", options.files, "Files")->required();

  try {
    app.parse(argc, argv);
    if (options.domain.empty()) {
      options.domain = environmentDomain().value_or("0");
      if (!parseDomain(options.domain)) {
        throw CLI::ValidationError("HANDOVER_DOMAIN", check_domain(options.domain));
      }
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitDone : kExitUsage;
  }
  if (check->parsed()) return notBuiltYet("check");
  if (prepare->parsed()) return notBuiltYet("prepare");
  if (!options.config.empty()) return notBuiltYet("--config");
  return serve(options, *parseDomain(options.domain));
}

}  // namespace
}  // namespace handover

int main(int argc, char** argv) {
  try {
    return handover::run(argc, argv);
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
