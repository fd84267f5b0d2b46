// SPDX-License-Identifier: Apache-2.0
// The real PlanService: cells from files, maps and grasp sets from the cache, plans from the core.
#pragma once

#include "cells/decomposition_cache.hpp"
#include "cells/resource_cache.hpp"
#include "core/planning/plan_transport.hpp"
#include "runtime/plan_service.hpp"
#include "settings/cell_file.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace handover {

/// The cells of one daemon.
class CellService : public PlanService {
 public:
  /// Loads every cell (names under <root>/config/cells or files). @throws FileError.
  CellService(const std::filesystem::path& root, const std::vector<std::string>& cells,
              const std::filesystem::path& cache_folder, ResourceCache::Progress progress,
              bool force);

  std::vector<CellInfo> cells() const override;
  bool prepareNext(const Deadline& deadline) override;
  void prepare(const PlanRequest& request, const Deadline& deadline) override;
  std::optional<Outcome> plan(const PlanRequest& request, PlanEventSink& sink,
                              const Deadline& deadline, const OthersWait& others_wait) override;

  /// Every cell.
  void prepareAll(const Deadline& deadline);
  /// The same as plan() where nobody else waits: what is missing is made.
  Outcome planAlone(const PlanRequest& request, PlanEventSink& sink, const Deadline& deadline);

  /// What plan() solves; or the outcome of a request that cannot be planned at all.
  /// @throws NotPrepared
  std::variant<TransportProblem, Outcome> problemOf(const PlanRequest& request,
                                                    const Deadline& deadline,
                                                    Missing missing = Missing::kMake);

 private:
  struct Loaded {
    Cell cell;
    /// Without overrides.
    Cell::Instance instance;
    /// By task object.
    std::map<std::string, std::shared_ptr<const CollisionScene>> collision;
    std::uint64_t revision = 1;
    std::string scene_hash;  ///< of the first task
  };

  void load(const std::filesystem::path& root, const std::vector<std::string>& cells);
  const Loaded* find(const std::string& cell) const;
  void prepareCell(const Loaded& loaded, const Deadline& deadline);
  std::vector<RobotResources> resources(const Scene& scene, const std::string& object,
                                        const Deadline& deadline, Missing missing);
  /// The cell as the request has it; or every fault.
  /// @throws NotPrepared; std::runtime_error past the deadline
  std::variant<Cell::Instance, std::vector<Fault>> instanceOf(const Loaded& loaded,
                                                              const PlanRequest& request,
                                                              const Deadline& deadline,
                                                              Missing missing) const;
  std::variant<const Loaded*, Outcome> cellOf(const PlanRequest& request) const;
  /// The request against the cell, without maps and grasps; or the outcome of one that cannot be
  /// planned at all. @throws as instanceOf()
  std::optional<Outcome> resolve(const Loaded& loaded, const PlanRequest& request,
                                 const Deadline& deadline, Missing missing,
                                 TransportProblem& problem);
  /// Adds maps and grasps. @throws NotPrepared; std::runtime_error past the deadline
  void equip(TransportProblem& problem, const Deadline& deadline, Missing missing);
  /// The failure that shows without maps and grasps, told at once; if any.
  static std::optional<Outcome> unfitScene(TransportProblem& problem, PlanEventSink& sink);
  /// The request against the cell; or the outcome of one that cannot be planned at all.
  std::variant<TransportProblem, Outcome> problemOf(const Loaded& loaded,
                                                    const PlanRequest& request,
                                                    const Deadline& deadline, Missing missing);
  Outcome solve(const PlanRequest& request, const TransportProblem& problem, PlanEventSink& sink,
                const Deadline& deadline, const OthersWait& others_wait);
  /// Adds to an explanation what would help.
  void addNearestFix(const Loaded& loaded, const PlanRequest& request,
                     const TransportProblem& problem, const Deadline& deadline,
                     const OthersWait& others_wait, std::uint64_t most_work, Failed& failed);

  std::vector<Loaded> cells_;
  std::size_t next_to_prepare_ = 0;
  ModelCache models_;
  DecompositionCache divide_;
  ResourceCache cache_;
};

}  // namespace handover
