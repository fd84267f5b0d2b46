// SPDX-License-Identifier: Apache-2.0
// handover-bench: what our parts cost beside others', measured in one run.
#include "benches.hpp"
#include "ping_pong.hpp"
#include "settings/cell_file.hpp"

#include <CLI/CLI.hpp>

#include <fstream>
#include <iostream>

namespace handover::bench {

std::shared_ptr<const Scene> butlerScene() {
  const std::filesystem::path root = HANDOVER_SOURCE_DIR;
  ModelCache models;
  const Cell cell = Cell::load(root / "config/cells/butler.yaml", root, models);
  return std::get<Cell::Instance>(cell.instantiate({}, 1)).scene;
}

namespace {

Report everything(const Effort& effort) {
  const auto scene = butlerScene();
  Report report;
  const auto part = [&report](const char* what, const Report& found) {
    report.add(found);
    std::cerr << what << " done\n";
  };
  part("butler over DDS", daemonBench(effort));
  part("inverse kinematics", ikBench(*scene, effort));
  part("state checks", stateBench(scene, effort));
  part("maps", mapBench(*scene, effort));
  return report;
}

int run(int argc, char** argv) {
  CLI::App app{"Measures our parts beside others'", "handover-bench"};
  std::string output;
  bool smoke = false;
  int pong_domain = -1;
  app.add_option("--output", output, "Write the rows here, as JSON");
  app.add_flag("--smoke", smoke, "As little as possible: to see that it runs");
  app.add_option("--pong", pong_domain, "Answer pings in this DDS domain, until killed");
  CLI11_PARSE(app, argc, argv);
  if (pong_domain >= 0) {
    answerPings(pong_domain);
    return 0;
  }
  Effort effort;
  if (smoke) {
    effort = {.rounds = 1, .requests = 2, .pings = 3, .poses = 20, .states = 20, .samples = 2000};
  }
  std::cout << machine() << '\n';
  const Report report = everything(effort);
  std::cout << '\n';
  printTable(std::cout, report);
  if (!output.empty()) {
    std::ofstream out(output);
    out << json(report);
    if (!out.flush()) throw std::runtime_error("cannot write " + output);
  }
  return 0;
}

}  // namespace
}  // namespace handover::bench

int main(int argc, char** argv) {
  try {
    return handover::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "handover-bench: " << error.what() << std::endl;
    return 1;
  }
}
