// SPDX-License-Identifier: Apache-2.0
#include "layers.hpp"

namespace handover::test {
namespace {

// Each may include those before it, and common.
const std::vector<std::string> kCoreModules{
    "decomposition", "model", "model_io", "kinematics", "collision",
    "reachability",  "grasp", "motion",   "task",       "planning"};

std::vector<Layer> makeLayers() {
  std::vector<Layer> all;
  std::vector<std::string> earlier{"common"};
  for (const std::string& module : kCoreModules) {
    all.push_back({"server/core/" + module, earlier});
    earlier.push_back("server/core/" + module);
  }
  const auto withCore = [&](std::vector<std::string> more) {
    more.insert(more.end(), earlier.begin(), earlier.end());
    return more;
  };
  const std::vector<Layer> others{
      {"common", {}},
      {"common/wire", {"common"}},
      {"client/verify", {}},  // alone: it shares nothing with what it checks
      {"client/include", {"common"}},
      {"client/plan_file", {"client/include", "common"}},
      {"client/src", {"client/include", "common", "common/wire"}},
      {"client/view", {"client/include", "common"}},
      {"client/ctl", {"client/include", "client/plan_file", "client/view", "common"}},
      {"server/settings", withCore({})},
      {"server/runtime", withCore({"server/settings"})},
      {"server/cells", withCore({"server/runtime", "server/settings"})},
      {"server/dds", {"common", "common/wire", "server/runtime"}},
      {"server",
       {"common", "common/wire", "server/cells", "server/dds", "server/runtime",
        "server/settings"}},
  };
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

}  // namespace

const std::vector<Layer>& layers() {
  static const std::vector<Layer> all = makeLayers();
  return all;
}

const std::vector<Library>& libraries() {
  static const std::vector<Library> all{
      {"Bullet", "bt[A-Z]|Bullet|LinearMath/", {"server/core/collision"}, true},
      {"Qhull", "libqhull", {"server/core/decomposition"}, true},
      {"OMPL", "ompl/", {"server/core/motion"}, true},
      {"urdfdom", "urdf_|console_bridge/", {"server/core/model_io"}, true},
      {"tinyxml2", "tinyxml2", {"server/core/model_io", "client/verify", "client/view"}},
      {"assimp", "assimp/", {"server/core/model_io", "client/verify", "client/view"}, true},
      {"YAML", "yaml-cpp/", {"server/settings", "client/verify"}, true},
      {"FCL", "fcl/", {"client/verify"}},
      {"KDL", "kdl/", {"client/verify"}},
      {"DDS",
       "fast(dds|rtps|cdr)/|handover(PubSubTypes)?\\.h",
       {"common/wire", "server/dds", "client/src"}},
      {"spdlog", "spdlog/", {"common", "client/ctl"}},
      {"CLI11", "CLI/", {"client/ctl", "client/verify", "server"}},
  };
  return all;
}

const std::string& bannedFromCore() {
  static const std::string headers =
      "fast(dds|rtps|cdr)/|handover(PubSubTypes)?\\.h|yaml-cpp/|spdlog/|CLI/"
      "|(iostream|print|syncstream|thread|future)$";
  return headers;
}

const std::vector<std::string>& generatedHeaders() {
  static const std::vector<std::string> headers{"handover.h", "handoverPubSubTypes.h"};
  return headers;
}

}  // namespace handover::test
