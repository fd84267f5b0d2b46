// SPDX-License-Identifier: Apache-2.0
// config/handoverd.yaml -> the daemon's settings.
#pragma once

#include "core/model_io/file_fault.hpp"
#include "settings/yaml_node.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace handover {

/// What requests and clients may take. Whatever goes beyond is rejected as busy, with the reason.
struct DaemonLimits {
  int queue = 256;           ///< requests that wait, of all clients
  int client_queue = 64;     ///< of one client
  double client_cpu_s = 0;   ///< planning and making for one client within an hour; 0: no limit
  int client_cache_mib = 0;  ///< maps, grasp sets and parts made for it within an hour; 0: no limit
  double deadline_s = 0;     ///< of requests that name none; 0: none
  bool operator==(const DaemonLimits&) const = default;
};

struct DaemonSettings {
  std::vector<std::string> cells;  ///< names in config/cells, or files
  bool share_cells = false;  ///< other daemons of a cell answer its requests too; else one leads
  int domain = 0;            ///< 0 to 232
  int threads = 1;           ///< workers, 1 to 64
  std::string transport = "loopback";          ///< loopback, lan, discovery_server or profile
  std::vector<std::string> discovery_servers;  ///< host:port, for transport discovery_server
  std::string profile;                         ///< XML file, for transport profile
  std::string cache;                           ///< folder; empty: $XDG_CACHE_HOME/handover
  int cache_mib = 2048;  ///< what the folder may hold; what is unused the longest goes
  DaemonLimits limits;
  std::string log_level = "info";  ///< trace, debug, info, warn, error or off
  bool operator==(const DaemonSettings&) const = default;
};

/// Absent keys keep their defaults. @throws FileError with every fault and its line.
DaemonSettings readDaemonSettings(const std::filesystem::path& file);

/// What is wrong with the cells that such a file names: none at all, or one without a file.
std::vector<FileFault> checkNamedCells(const YamlNode& document, const std::string& shown_file,
                                       const std::filesystem::path& root);

}  // namespace handover
