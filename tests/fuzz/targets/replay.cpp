// SPDX-License-Identifier: Apache-2.0
// Runs a target over its seeds and what fuzzing has found before.
// usage: PROGRAM CORPUS            every file of a folder, which may be missing
//        PROGRAM --write FOLDER    the seeds as files, to fuzz from
#include "target.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

namespace handover::fuzz {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

/// In an order that is always the same.
std::vector<fs::path> filesOf(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

int replay(const fs::path& corpus) {
  std::size_t count = 0;
  for (const std::string& seed : seeds()) {
    run(seed);
    ++count;
  }
  for (const fs::path& file : filesOf(corpus)) {
    std::cout << file.filename().string() << std::endl;  // known, should it be the last
    run(contentOf(file));
    ++count;
  }
  std::cout << count << " inputs\n";
  return 0;
}

int writeSeeds(const fs::path& folder) {
  fs::create_directories(folder);
  int number = 0;
  for (const std::string& seed : seeds()) {
    std::ofstream(folder / ("seed-" + std::to_string(number++)), std::ios::binary) << seed;
  }
  return 0;
}

}  // namespace
}  // namespace handover::fuzz

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "--write") {
    return handover::fuzz::writeSeeds(arguments[1]);
  }
  if (arguments.size() != 1) {
    std::cerr << "usage: " << argv[0] << " CORPUS | --write FOLDER\n";
    return 2;
  }
  return handover::fuzz::replay(arguments[0]);
}
