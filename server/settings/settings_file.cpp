// SPDX-License-Identifier: Apache-2.0
#include "settings/settings_file.hpp"

#include "settings/roots.hpp"
#include "settings/yaml_reader.hpp"

#include <set>

namespace handover {
namespace {

std::set<std::string> cellNames(const std::filesystem::path& root) {
  std::set<std::string> names;
  std::error_code none;
  const std::filesystem::directory_iterator files(root / "config" / "cells", none), end;
  if (none) return names;
  for (const auto& file : files) {
    if (file.path().extension() == ".yaml") names.insert(file.path().stem().string());
  }
  return names;
}

void readCount(YamlMap& map, const char* key, int least, int& value) {
  constexpr int kMost = 1'000'000;
  if (const YamlValue* given = map.find(key)) value = given->integer(least, kMost).value_or(value);
}

void readSeconds(YamlMap& map, const char* key, double& value) {
  if (const YamlValue* given = map.find(key)) value = given->number({0, 86'400}).value_or(value);
}

/// A list of names, or a map of them and of how they are shared.
void readCells(const YamlValue& value, DaemonSettings& settings) {
  if (!value.isMap()) {
    settings.cells = value.texts().value_or(settings.cells);
    return;
  }
  auto map = value.map();
  if (const YamlValue* names = map->find("names")) {
    settings.cells = names->texts().value_or(settings.cells);
  }
  if (const YamlValue* sharing = map->find("sharing")) {
    settings.share_cells = sharing->oneOf({"standby", "shared"}).value_or("standby") == "shared";
  }
  map->finish();
}

void readLimits(const YamlValue& value, DaemonLimits& limits) {
  auto map = value.map();
  if (!map) return;
  readCount(*map, "queue", 1, limits.queue);
  readCount(*map, "client_queue", 1, limits.client_queue);
  readSeconds(*map, "client_cpu_s", limits.client_cpu_s);
  readCount(*map, "client_cache_mib", 0, limits.client_cache_mib);
  readSeconds(*map, "deadline_s", limits.deadline_s);
  map->finish();
}

}  // namespace

DaemonSettings readDaemonSettings(const std::filesystem::path& file) {
  const std::string shown_file = file.string();
  YamlReport report;
  DaemonSettings settings;
  const YamlNode document = parseYaml(readSettingsText(file), shown_file);
  auto map = YamlValue(document, "", report).map();
  if (!map) throw FileError(report.inFile(shown_file));
  if (const YamlValue* version = map->require("version")) version->integer(1, 1);
  if (const YamlValue* cells = map->find("cells")) {
    readCells(*cells, settings);
  }
  if (const YamlValue* domain = map->find("domain")) {
    settings.domain = domain->integer(0, 232).value_or(0);
  }
  if (const YamlValue* threads = map->find("threads")) {
    settings.threads = threads->integer(1, 64).value_or(1);
  }
  const YamlValue* transport = map->find("transport");
  if (transport != nullptr) {
    settings.transport = transport->oneOf({"loopback", "lan", "discovery_server", "profile"})
                             .value_or(settings.transport);
  }
  if (const YamlValue* servers = map->find("discovery_servers")) {
    settings.discovery_servers = servers->texts().value_or(settings.discovery_servers);
  }
  if (const YamlValue* profile = map->find("profile"); profile != nullptr && !profile->isEmpty()) {
    settings.profile = profile->text().value_or("");
  }
  if (const YamlValue* cache = map->find("cache"); cache != nullptr && !cache->isEmpty()) {
    settings.cache = cache->text().value_or("");
  }
  readCount(*map, "cache_mib", 1, settings.cache_mib);
  if (const YamlValue* limits = map->find("limits")) readLimits(*limits, settings.limits);
  if (const YamlValue* level = map->find("log_level")) {
    settings.log_level = level->oneOf({"trace", "debug", "info", "warn", "error", "off"})
                             .value_or(settings.log_level);
  }
  map->finish();
  if (settings.transport == "discovery_server" && settings.discovery_servers.empty()) {
    report.add("transport", "discovery_server needs discovery_servers: [host:port]");
  }
  if (settings.transport == "profile" && settings.profile.empty()) {
    report.add("transport", "profile needs profile: FILE");
  }
  if (!report.clean()) throw FileError(report.inFile(shown_file));
  return settings;
}

std::vector<FileFault> checkNamedCells(const YamlNode& document, const std::string& shown_file,
                                       const std::filesystem::path& root) {
  const YamlNode* cells = document.find("cells");
  if (cells != nullptr && cells->find("names") != nullptr) cells = cells->find("names");
  if (cells == nullptr || cells->values.empty()) {
    const int line = cells == nullptr ? 0 : cells->line;
    return {{shown_file, line, "cells: names no cell; the daemon needs one here or as --cell"}};
  }
  std::vector<FileFault> faults;
  for (const YamlNode& cell : cells->values) {
    const std::filesystem::path named = cellFile(cell.text, root);
    std::error_code ignored;
    if (std::filesystem::is_regular_file(named, ignored)) continue;
    const bool is_file = cell.text.find('/') != std::string::npos;
    const std::string nearest = is_file ? "" : nearestOf(cellNames(root), cell.text);
    faults.push_back({shown_file, cell.line,
                      "cells: no cell '" + cell.text + "' (looked for " + named.string() + ")" +
                          nearestSaid(nearest)});
  }
  return faults;
}

}  // namespace handover
