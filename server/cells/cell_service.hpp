// SPDX-License-Identifier: Apache-2.0
// The real PlanService: cells from files, maps and grasp sets from the cache, plans from the core.
#pragma once

#include "cells/decomposition_cache.hpp"
#include "cells/resource_cache.hpp"
#include "core/planning/plan_transport.hpp"
#include "runtime/plan_service.hpp"
#include "settings/cell_file.hpp"

#include <handover/common/mutex.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace handover {

/// The cells of one daemon. Safe from any thread.
class CellService : public PlanService {
 public:
  /// Loads every cell (names under <root>/config/cells or files). @throws FileError;
  /// std::runtime_error past the deadline.
  CellService(std::filesystem::path root, std::vector<std::string> cells,
              std::filesystem::path cache_folder, ResourceCache::Progress progress, bool force,
              const Deadline& deadline = {});

  std::shared_ptr<const ServedCells> served() const override;
  void reload(const Deadline& deadline) override;
  bool prepareNext(const Deadline& deadline) override;
  void prepare(const ServedCells& cells, const PlanRequest& request,
               const Deadline& deadline) override;
  std::optional<Outcome> plan(const ServedCells& cells, const PlanRequest& request,
                              PlanEventSink& sink, const Deadline& deadline,
                              const OthersWait& others_wait) override;

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
  struct Loaded;
  struct Cells;
  using CellsPtr = std::shared_ptr<const Cells>;

  CellsPtr current() const;
  CellsPtr load(std::uint64_t revision, const DecompositionCache& divide) const;
  std::vector<Loaded> loadAll(std::uint64_t revision, const DecompositionCache& divide) const;
  void prepareCell(const Loaded& loaded, const Deadline& deadline);
  std::vector<RobotResources> resources(const Scene& scene, const std::string& object,
                                        const Deadline& deadline, Missing missing);
  /// The cell as the request has it; or every fault.
  /// @throws NotPrepared; std::runtime_error past the deadline
  static std::variant<Cell::Instance, std::vector<Fault>> instanceOf(const Loaded& loaded,
                                                                     const PlanRequest& request,
                                                                     const Deadline& deadline,
                                                                     Missing missing);
  static std::variant<const Loaded*, Outcome> cellOf(const Cells& cells,
                                                     const PlanRequest& request);
  /// The request against the cell, without maps and grasps; or the outcome of one that cannot be
  /// planned at all. @throws as instanceOf()
  std::optional<Outcome> resolve(const Loaded& loaded, const PlanRequest& request,
                                 const Deadline& deadline, Missing missing,
                                 TransportProblem& problem);
  /// Adds maps and grasps. @throws NotPrepared; std::runtime_error past the deadline
  void equip(TransportProblem& problem, const Deadline& deadline, Missing missing);
  /// The failure that shows without maps and grasps, told at once; if any.
  static std::optional<Outcome> unfitScene(TransportProblem& problem, PlanEventSink& sink);
  /// As the public one.
  std::variant<TransportProblem, Outcome> problemOf(const Cells& cells, const PlanRequest& request,
                                                    const Deadline& deadline, Missing missing);
  std::variant<TransportProblem, Outcome> problemOf(const Loaded& loaded,
                                                    const PlanRequest& request,
                                                    const Deadline& deadline, Missing missing);
  Outcome solve(const Loaded& loaded, const PlanRequest& request, const TransportProblem& problem,
                PlanEventSink& sink, const Deadline& deadline, const OthersWait& others_wait);
  /// Adds to an explanation what would help.
  void addNearestFix(const Loaded& loaded, const PlanRequest& request,
                     const TransportProblem& problem, const Deadline& deadline,
                     const OthersWait& others_wait, std::uint64_t most_work, Failed& failed);

  const std::filesystem::path root_, cache_folder_;
  const std::vector<std::string> names_;
  const ResourceCache::Progress progress_;
  ResourceCache cache_;

  mutable Mutex mutex_;
  CellsPtr cells_ HANDOVER_GUARDED_BY(mutex_);
  std::size_t next_to_prepare_ HANDOVER_GUARDED_BY(mutex_) = 0;  // of cells_
};

}  // namespace handover
