// SPDX-License-Identifier: Apache-2.0
// Maps, grasp sets and arm kinematics: read from the cache folder or made.
#pragma once

#include "cells/cache_folder.hpp"
#include "core/planning/transport_problem.hpp"

#include <handover/common/deadline.hpp>
#include <handover/common/mutex.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace handover {

/// Something is not in memory, and whoever asked does not want to wait until it is.
struct NotPrepared : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What becomes of a product that is not in memory: it is read or made, which may take minutes; or
/// NotPrepared is thrown at once.
enum class Missing { kMake, kThrow };

/// Offline products of one cache folder, made when missing or out of date. Safe from any thread:
/// each product is made once, by the first that asks for it; others that want the same wait, those
/// that want another don't.
class ResourceCache {
 public:
  /// What is being made ("maps crichton", "grasps cup hubo/left_hand") and the fraction done.
  using Progress = std::function<void(const std::string& what, double fraction)>;

  /// `force`: make everything anew, whatever the cache holds. The folder has a path, but where only
  /// kinematics() is asked.
  ResourceCache(CacheFolder folder, Progress progress, bool force);

  /// @throws std::runtime_error with the reason when the map can neither be read nor made.
  std::shared_ptr<const ReachabilityMap> map(const SceneRobot& robot, ArmId arm,
                                             const Deadline& deadline, Missing missing);
  /// The grasps of `object` by the hand of the arm; nullptr when it has none. An empty set says
  /// why.
  std::shared_ptr<const GraspSet> grasps(const SceneObject& object, const SceneRobot& robot,
                                         ArmId arm, const Deadline& deadline, Missing missing);
  std::shared_ptr<const ArmKinematics> kinematics(const std::shared_ptr<const RobotModel>& model,
                                                  ArmId arm);

 private:
  using Clock = Deadline::Clock;

  /// What is in memory, with its files where it has any.
  template <typename Product>
  struct Kept {
    std::shared_ptr<const Product> product;
    std::vector<std::filesystem::path> files;
    Clock::time_point used{};  ///< last
    Clock::time_point told{};  ///< when the files were last told to be in use
  };

  template <typename Product>
  struct Shelf {
    std::size_t most;                             ///< products; the one unused the longest goes
    std::map<std::uint64_t, Kept<Product>> kept;  ///< by hash
    std::set<std::uint64_t> in_progress;
  };

  /// @param make  reads or makes the product: a Kept<Product>
  template <typename Product, typename Make>
  std::shared_ptr<const Product> get(Shelf<Product>& shelf, std::uint64_t hash,
                                     const Deadline& deadline, Missing missing, Make make);
  template <typename Product>
  const std::shared_ptr<const Product>& use(Kept<Product>& kept);
  /// The maps of a robot's arms, made together.
  using RobotMaps = std::vector<std::shared_ptr<const ReachabilityMap>>;

  struct ModelKinematics {
    std::weak_ptr<const RobotModel> model;  ///< gone with its cells when they are read again
    std::shared_ptr<const ArmKinematics> kinematics;
  };

  struct MapFile {
    std::filesystem::path path;
    std::uint64_t hash;
  };

  std::vector<MapFile> mapFiles(const SceneRobot& robot) const;
  /// nullptr when one of them is missing or does not fit.
  static std::shared_ptr<const RobotMaps> readMaps(const std::vector<MapFile>& files);
  std::shared_ptr<const RobotMaps> makeMaps(const SceneRobot& robot,
                                            const std::vector<MapFile>& files,
                                            const Deadline& deadline);
  std::filesystem::path graspFile(const SceneObject& object, const SceneRobot& robot, ArmId arm,
                                  std::uint64_t hash) const;
  GraspSet readOrMakeGrasps(const SceneObject& object, const SceneRobot& robot, ArmId arm,
                            std::uint64_t hash, const std::filesystem::path& file,
                            const Deadline& deadline);

  const CacheFolder folder_;
  Progress progress_;
  bool force_;
  Mutex mutex_;
  Condition made_;
  // Shelves are guarded too; clang does not follow them into get().
  Shelf<RobotMaps> maps_{64, {}, {}};    // some MB each
  Shelf<GraspSet> grasps_{256, {}, {}};  // some 100 KB each
  std::map<std::pair<const RobotModel*, ArmId>, ModelKinematics> kinematics_
      HANDOVER_GUARDED_BY(mutex_);
};

}  // namespace handover
