// SPDX-License-Identifier: Apache-2.0
// The real PlanService: cells from files, maps and grasp sets from the cache, plans from the core.
#pragma once

#include "core/collision/collision_scene.hpp"
#include "runtime/plan_service.hpp"
#include "settings/cell_file.hpp"

#include <handover/common/mutex.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace handover {

/// Offline products of one cache folder, made when missing or out of date. Safe from any thread:
/// each product is made once, by the first that asks for it; others that want the same wait, those
/// that want another don't.
class ResourceCache {
 public:
  /// What is being made ("map crichton/left", "grasps cup hubo/left_hand") and the fraction done.
  using Progress = std::function<void(const std::string& what, double fraction)>;

  /// `force`: make everything anew, whatever the cache holds.
  ResourceCache(std::filesystem::path folder, Progress progress, bool force);

  /// @throws std::runtime_error with the reason when the map can neither be read nor made.
  std::shared_ptr<const ReachabilityMap> map(const SceneRobot& robot, int arm,
                                             const Deadline& deadline);
  /// The grasps of `object` by the hand of the arm; nullptr when the hand finds none.
  std::shared_ptr<const GraspSet> grasps(const SceneObject& object, const SceneRobot& robot,
                                         int arm, const Deadline& deadline);
  std::shared_ptr<const ArmKinematics> kinematics(const std::shared_ptr<const RobotModel>& model,
                                                  int arm);

 private:
  template <typename Product>
  struct Shelf {
    std::map<std::uint64_t, std::shared_ptr<const Product>> products;  ///< by hash
    std::set<std::uint64_t> in_the_making;
  };

  template <typename Product, typename Make>
  std::shared_ptr<const Product> get(Shelf<Product>& shelf, std::uint64_t hash,
                                     const Deadline& deadline, Make make);
  std::shared_ptr<const ReachabilityMap> makeMap(const SceneRobot& robot, int arm,
                                                 std::uint64_t hash, const Deadline& deadline);
  std::shared_ptr<const GraspSet> makeGrasps(const SceneObject& object, const SceneRobot& robot,
                                             int arm, std::uint64_t hash, const Deadline& deadline);

  std::filesystem::path folder_;
  Progress progress_;
  bool force_;
  Mutex mutex_;
  Condition made_;
  // Shelves are guarded too; clang does not follow them into get().
  Shelf<ReachabilityMap> maps_;
  Shelf<GraspSet> grasps_;
  std::map<std::pair<const RobotModel*, int>, std::shared_ptr<const ArmKinematics>> kinematics_
      HANDOVER_GUARDED_BY(mutex_);
};

/// The cells of one daemon.
class CellService : public PlanService {
 public:
  /// Loads every cell (names under <root>/config/cells or files). @throws FileError.
  CellService(const std::filesystem::path& root, const std::vector<std::string>& cells,
              const std::filesystem::path& cache_folder, ResourceCache::Progress progress,
              bool force);

  std::vector<CellInfo> cells() const override;
  void prepare(const Deadline& deadline) override;
  Outcome plan(const PlanRequest& request, StageSink& sink, const Deadline& deadline) override;

  /// What plan() solves; or the outcome of a request that cannot be planned at all.
  std::variant<HandoverProblem, Outcome> problemOf(const PlanRequest& request,
                                                   const Deadline& deadline);

 private:
  struct Loaded {
    Cell cell;
    /// Without overrides.
    Cell::Instance instance;
    /// By task object.
    std::map<std::string, std::shared_ptr<const CollisionScene>> collision;
    std::uint64_t revision = 1;
  };

  const Loaded* find(const std::string& cell) const;
  std::vector<RobotResources> resources(const Scene& scene, const std::string& object,
                                        const Deadline& deadline);
  /// The request against the cell; or the outcome of one that cannot be planned at all.
  std::variant<HandoverProblem, Outcome> problemOf(const Loaded& loaded, const PlanRequest& request,
                                                   const Deadline& deadline);
  /// Adds to an explanation what would help.
  void addNearestFix(const Loaded& loaded, const PlanRequest& request,
                     const HandoverProblem& problem, const Deadline& deadline, Failed& failed);

  std::vector<Loaded> cells_;
  ModelCache models_;
  ResourceCache cache_;
};

}  // namespace handover
