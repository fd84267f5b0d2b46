// SPDX-License-Identifier: Apache-2.0
// A URDF as orocos_kdl sees it, read by code that shares nothing with core/model.
#pragma once

#include <kdl/tree.hpp>

#include <filesystem>
#include <map>
#include <string>

namespace handover::testing {

class KdlRobot {
 public:
  explicit KdlRobot(const std::filesystem::path& urdf);

  /// The joints from one link down to another. @throws std::runtime_error when there is no such
  /// way.
  KDL::Chain chain(const std::string& base, const std::string& tip) const;

  /// Pose of a link in the root link, from the positions of the joints that are no mimics [rad].
  KDL::Frame pose(const std::string& link, const std::map<std::string, double>& q) const;

 private:
  struct Mimic {
    std::string master;
    double multiplier = 1, offset = 0;
  };

  KDL::Tree tree_;
  std::string root_;
  std::map<std::string, Mimic> mimics_;
};

}  // namespace handover::testing
