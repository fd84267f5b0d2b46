// SPDX-License-Identifier: Apache-2.0
#include "cells/cell_service.hpp"

#include "cells/nearest_fix.hpp"
#include "cells/request_task.hpp"
#include "core/planning/collision_context.hpp"
#include "core/planning/scene_validity.hpp"
#include "core/planning/workspaces.hpp"
#include "settings/roots.hpp"

#include <handover/common/log.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

namespace handover {
namespace {

/// For plans that are only asked whether they exist.
class NullSink : public PlanEventSink {
 public:
  void emit(PlanEventPayload) override {}
};

/// Whether where the last robot of the chain stands can have to do with a failure: what others
/// alone cannot do no move of it helps, unless it is in the way.
bool lastMatters(const Failed& failed, const std::string& robot) {
  const auto inTheWay = [&] {
    for (const auto& cause : failed.explanation.causes) {
      for (const auto& body : {cause.pair.first, cause.pair.second}) {
        if (body.starts_with(robot + "/")) return true;
      }
    }
    return false;
  };
  switch (failed.reason) {
    case FailureReason::kGoalUnreachable:
    case FailureReason::kNoGraspAtGoal:
    case FailureReason::kNoCommonWorkspace:
    case FailureReason::kNoHandoverPose:
    case FailureReason::kNoPath:
      return true;
    case FailureReason::kStartInCollision:
    case FailureReason::kGoalInCollision:
    case FailureReason::kNoGraspAtStart:
      return inTheWay();
    case FailureReason::kUnspecified:
    case FailureReason::kStartUnreachable:
    case FailureReason::kNoGrasp:
    case FailureReason::kStartUnsupported:
    case FailureReason::kGoalUnsupported:
    case FailureReason::kDeadline:
    case FailureReason::kInternal:
      return false;
  }
  return false;
}

Rejected badRequest(std::vector<Fault> faults) {
  return {RejectionReason::kBadRequest, std::move(faults)};
}

}  // namespace

struct CellService::Loaded {
  Cell cell;
  /// For meshes that requests bring.
  DecompositionCache divide;
  /// Without overrides.
  Cell::Instance instance;
  std::uint64_t revision;
  std::string scene_hash;  ///< of the first task
  /// By task object.
  std::map<std::string, std::shared_ptr<const CollisionScene>> collision;

  Loaded(Cell of, const DecompositionCache& dividing, Cell::Instance as_it_is, std::uint64_t number)
      : cell(std::move(of)),
        divide(dividing),
        instance(std::move(as_it_is)),
        revision(number),
        scene_hash(sceneHash(*instance.scene, instance.tasks.front())) {
    for (const auto& task : instance.tasks) {
      auto& scene = collision[task.object];
      if (!scene) scene = collisionForTask(*instance.scene, task.object);
    }
  }

  CellInfo info() const {
    return {cell.name(), cell.taskNames(), revision, cell.variations(), scene_hash};
  }
};

namespace {

template <typename Cells>
auto* findCell(Cells& cells, const std::string& name) {
  const auto found = std::find_if(cells.begin(), cells.end(),
                                  [&](const auto& loaded) { return loaded.cell.name() == name; });
  return found == cells.end() ? nullptr : &*found;
}

template <typename Cells>
std::vector<CellInfo> infosOf(const Cells& cells) {
  std::vector<CellInfo> infos;
  for (const auto& loaded : cells) infos.push_back(loaded.info());
  return infos;
}

template <typename Cells>
void tellRemarks(const Cells& cells) {
  const auto log = logger("cells");
  for (const auto& loaded : cells) {
    for (const FileFault& warning : loaded.cell.warnings()) log->warn("{}", warning.text());
    for (const FileFault& fact : loaded.cell.facts()) log->debug("{}", fact.text());
  }
}

}  // namespace

struct CellService::Cells : ServedCells {
  explicit Cells(std::vector<Loaded> cells) : ServedCells(infosOf(cells)), all(std::move(cells)) {}

  const std::vector<Loaded> all;
};

CellService::CellService(std::filesystem::path root, std::vector<std::string> cells,
                         const CacheFolder& cache_folder, ResourceCache::Progress progress,
                         bool force, const Deadline& deadline)
    : root_(std::move(root)),
      cache_folder_(cache_folder),
      names_(std::move(cells)),
      progress_(std::move(progress)),
      cache_(cache_folder_, progress_, force) {
  cells_ = load(1, DecompositionCache(cache_folder_, force, progress_, deadline));
  if (deadline.over()) throw std::runtime_error("stopped while cells were read");
}

CellService::CellsPtr CellService::load(std::uint64_t revision,
                                        const DecompositionCache& divide) const {
  std::vector<Loaded> cells;
  divide.loadInRounds([&] {
    cells = loadAll(revision, divide);
    return true;
  });
  tellRemarks(cells);
  return std::make_shared<const Cells>(std::move(cells));
}

std::vector<CellService::Loaded> CellService::loadAll(std::uint64_t revision,
                                                      const DecompositionCache& divide) const {
  std::vector<Loaded> cells;
  std::vector<FileFault> faults;
  ModelCache models;
  for (const auto& name : names_) {
    const auto file = cellFile(name, root_);
    Cell cell = Cell::load(file, root_, models, divide);
    if (findCell(cells, cell.name()) != nullptr) {
      faults.push_back({file.string(), 0, "a cell named '" + cell.name() + "' is loaded already"});
      continue;
    }
    auto instance = cell.instantiate({}, revision);
    if (auto* found = std::get_if<std::vector<Fault>>(&instance)) {
      for (const auto& fault : *found) {
        faults.push_back({file.string(), 0, fault.field + ": " + fault.message});
      }
      continue;
    }
    cells.emplace_back(std::move(cell), divide, std::get<Cell::Instance>(std::move(instance)),
                       revision);
  }
  if (!faults.empty()) throw FileError(std::move(faults));
  return cells;
}

CellService::CellsPtr CellService::current() const {
  const MutexLock lock(mutex_);
  return cells_;
}

std::shared_ptr<const ServedCells> CellService::served() const { return current(); }

void CellService::reload(const Deadline& deadline) {
  const std::uint64_t revision = current()->all.front().revision + 1;
  auto cells = load(revision, DecompositionCache(cache_folder_, false, progress_, deadline));
  if (deadline.over()) throw std::runtime_error("stopped while cells were read");
  const MutexLock lock(mutex_);
  cells_ = std::move(cells);
  next_to_prepare_ = 0;
}

void CellService::prepareCell(const Loaded& loaded, const Deadline& deadline) {
  std::set<std::string> objects;
  for (const auto& task : loaded.instance.tasks) objects.insert(task.object);
  for (const auto& object : objects) {
    resources(*loaded.instance.scene, object, deadline, Missing::kMake);
  }
}

bool CellService::prepareNext(const Deadline& deadline) {
  CellsPtr cells;
  std::size_t next = 0;
  {
    const MutexLock lock(mutex_);
    cells = cells_;
    next = next_to_prepare_;
  }
  if (next == cells->all.size()) return false;
  prepareCell(cells->all[next], deadline);
  const MutexLock lock(mutex_);
  if (cells_ != cells) return true;  // they were read again meanwhile
  return ++next_to_prepare_ < cells->all.size();
}

void CellService::prepareAll(const Deadline& deadline) {
  for (const Loaded& loaded : current()->all) prepareCell(loaded, deadline);
}

std::uint64_t CellService::prepare(const ServedCells& cells, const PlanRequest& request,
                                   const Deadline& deadline) {
  const std::uint64_t before = cache_folder_.writtenBytes();
  (void)problemOf(static_cast<const Cells&>(cells), request, deadline, Missing::kMake);
  return cache_folder_.writtenBytes() - before;
}

std::vector<RobotResources> CellService::resources(const Scene& scene, const std::string& object,
                                                   const Deadline& deadline, Missing missing) {
  const SceneObject& target = scene.objects[scene.findObject(object)];
  std::vector<RobotResources> all;
  for (const auto& robot : scene.robots) {
    RobotResources mine;
    for (const ArmId arm : IdRange<ArmId>(robot.model->arms.size())) {
      mine.kinematics.push_back(cache_.kinematics(robot.model, arm));
      mine.maps.push_back(cache_.map(robot, arm, deadline, missing));
      mine.grasps.push_back(cache_.grasps(target, robot, arm, deadline, missing));
    }
    all.push_back(std::move(mine));
  }
  return all;
}

std::variant<Cell::Instance, std::vector<Fault>> CellService::instanceOf(const Loaded& loaded,
                                                                         const PlanRequest& request,
                                                                         const Deadline& deadline,
                                                                         Missing missing) {
  if (request.overrides.empty()) return loaded.instance;
  const auto divide = [&](const TriangleMesh& mesh) -> Result<std::vector<TriangleMesh>> {
    if (auto known = loaded.divide.known(mesh)) return std::move(*known);
    if (missing == Missing::kThrow) throw NotPrepared("a mesh that is not divided");
    auto parts = loaded.divide.parts(mesh, deadline);
    if (deadline.over()) throw std::runtime_error("a mesh is not divided");
    return parts;
  };
  return loaded.cell.instantiate(request.overrides, loaded.revision, divide);
}

namespace {

/// Of a request that needs something made first.
Outcome stoppedMaking(const Deadline& deadline, const std::string& what) {
  if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
  Failed late;
  late.reason = FailureReason::kDeadline;
  late.explanation.filter = "prepare";
  late.explanation.text = "The deadline passed while parts, maps and grasps were made: " + what;
  late.explanation.causes = {{Cause::kDeadline, {}, {}, 1}};
  return late;
}

}  // namespace

std::optional<Outcome> CellService::resolve(const Loaded& loaded, const PlanRequest& request,
                                            const Deadline& deadline, Missing missing,
                                            TransportProblem& problem) {
  Cell::Instance instance = loaded.instance;
  std::vector<Fault> faults;
  auto changed = instanceOf(loaded, request, deadline, missing);
  if (auto* found = std::get_if<std::vector<Fault>>(&changed)) {
    faults = std::move(*found);  // the rest is checked against the cell as it is
  } else {
    instance = std::get<Cell::Instance>(std::move(changed));
  }
  problem.task = resolveTask(request, instance, faults);
  checkSearch(request, problem.task, faults);
  if (!faults.empty()) return badRequest(std::move(faults));
  problem.scene = instance.scene;
  if (!problem.task.held_by) {  // else where its grasp has it
    problem.scene = startOf(instance.scene, problem.task);
    const auto known = loaded.collision.find(problem.task.object);
    problem.collision = request.overrides.empty() && known != loaded.collision.end()
                            ? known->second
                            : collisionForTask(*problem.scene, problem.task.object);
  }
  problem.mode = request.mode;
  problem.search = request.search;
  problem.objective = objectiveOf(request);
  problem.seed = request.seed;
  problem.speed_scale = request.speed_scale;
  return std::nullopt;
}

void CellService::equip(TransportProblem& problem, const Deadline& deadline, Missing missing) {
  problem.resources = resources(*problem.scene, problem.task.object, deadline, missing);
  if (!problem.task.held_by) return;
  const auto [robot, arm] = *problem.task.held_by;
  auto held = std::make_shared<Scene>(*problem.scene);
  problem.held_grasp = takeInHand(*held, problem.task, problem.resources[robot].grasps[arm].get());
  problem.scene = startOf(std::move(held), problem.task);
  problem.collision = collisionForTask(*problem.scene, problem.task.object);
}

std::variant<TransportProblem, Outcome> CellService::problemOf(const Loaded& loaded,
                                                               const PlanRequest& request,
                                                               const Deadline& deadline,
                                                               Missing missing) {
  TransportProblem problem;
  try {
    if (auto refused = resolve(loaded, request, deadline, missing, problem)) return *refused;
    equip(problem, deadline, missing);
  } catch (const NotPrepared&) {
    throw;
  } catch (const std::runtime_error& error) {
    if (deadline.over()) return stoppedMaking(deadline, error.what());
    throw;
  }
  return problem;
}

std::variant<const CellService::Loaded*, Outcome> CellService::cellOf(const Cells& cells,
                                                                      const PlanRequest& request) {
  const Loaded* loaded = findCell(cells.all, request.cell);
  if (loaded == nullptr)
    return Rejected{RejectionReason::kUnknownCell, {{"cell", "no cell '" + request.cell + "'"}}};
  if (request.expected_revision && *request.expected_revision != loaded->revision) {
    return Rejected{
        RejectionReason::kSceneChanged,
        {{"expected_revision", "the scene's revision is " + std::to_string(loaded->revision)}}};
  }
  if (!request.expected_hash.empty() && request.expected_hash != loaded->scene_hash) {
    return Rejected{RejectionReason::kSceneChanged,
                    {{"expected_hash", "the scene's hash is " + loaded->scene_hash}}};
  }
  return loaded;
}

std::variant<TransportProblem, Outcome> CellService::problemOf(const Cells& cells,
                                                               const PlanRequest& request,
                                                               const Deadline& deadline,
                                                               Missing missing) {
  auto cell = cellOf(cells, request);
  if (auto* refused = std::get_if<Outcome>(&cell)) return std::move(*refused);
  return problemOf(*std::get<const Loaded*>(cell), request, deadline, missing);
}

std::variant<TransportProblem, Outcome> CellService::problemOf(const PlanRequest& request,
                                                               const Deadline& deadline,
                                                               Missing missing) {
  return problemOf(*current(), request, deadline, missing);
}

std::optional<Outcome> CellService::plan(const ServedCells& cells, const PlanRequest& request,
                                         PlanEventSink& sink, const Deadline& deadline,
                                         const OthersWait& others_wait) {
  auto cell = cellOf(static_cast<const Cells&>(cells), request);
  if (auto* refused = std::get_if<Outcome>(&cell)) return std::move(*refused);
  const Loaded& loaded = *std::get<const Loaded*>(cell);
  TransportProblem problem;
  bool placed = false;
  try {
    if (auto refused = resolve(loaded, request, deadline, Missing::kThrow, problem)) return refused;
    placed = true;
    equip(problem, deadline, Missing::kThrow);
  } catch (const NotPrepared&) {
    // Nothing is made for an object that cannot stand where it is said to.
    return placed && !problem.task.held_by ? unfitScene(problem, sink) : std::nullopt;
  }
  return solve(loaded, request, problem, sink, deadline, others_wait);
}

std::optional<Outcome> CellService::unfitScene(TransportProblem& problem, PlanEventSink& sink) {
  CollisionWorld world(problem.collision);
  std::optional<Failed> failed = checkBodies(problem, world, problem.task);
  if (!failed) return std::nullopt;
  failed->explanation.fix_text = "Not sought: maps or grasps would have to be made first.";
  sink.emit(snapshot(*problem.scene, problem.task, problem.seed));
  sink.emit(Failure{failed->reason, failed->explanation});
  return *failed;
}

Outcome CellService::planAlone(const PlanRequest& request, PlanEventSink& sink,
                               const Deadline& deadline) {
  const CellsPtr cells = current();
  auto cell = cellOf(*cells, request);
  if (auto* refused = std::get_if<Outcome>(&cell)) return std::move(*refused);
  const Loaded& loaded = *std::get<const Loaded*>(cell);
  auto problem = problemOf(loaded, request, deadline, Missing::kMake);
  if (auto* refused = std::get_if<Outcome>(&problem)) return std::move(*refused);
  return solve(loaded, request, std::get<TransportProblem>(problem), sink, deadline,
               [] { return false; });
}

Outcome CellService::solve(const Loaded& loaded, const PlanRequest& request,
                           const TransportProblem& problem, PlanEventSink& sink,
                           const Deadline& deadline, const OthersWait& others_wait) {
  SearchEffort effort;
  Outcome outcome = planTransport(problem, sink, deadline, &effort);
  auto* failed = std::get_if<Failed>(&outcome);
  if (failed == nullptr) return outcome;
  Explanation& why = failed->explanation;
  if (!request.wants_fix) why.fix_text = "Not sought: the request declined it.";
  sink.emit(Failure{failed->reason, why});
  sink.emit(workspacesOf(problem, *failed));
  if (request.wants_fix) {
    addNearestFix(loaded, request, problem, deadline, others_wait,
                  std::max(kLeastFixWork, effort.work()), *failed);
  }
  if (!why.nearest_fix.empty()) sink.emit(Fix{why.nearest_fix, why.fix_text});
  if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
  return outcome;
}

namespace {

/// Enough to tell that a moved cell has a plan: as much as most plans take.
SearchSettings quickSearch(SearchSettings settings) {
  settings.thorough_pruning = settings.pruning;
  settings.wide_poses = 500;
  settings.wide_poses_counted = 0;
  settings.turned_looks = 10;
  settings.scattered_poses = 0;
  settings.most_ik_looks = 3'000;
  settings.motion_attempts = 3;
  settings.grasp_attempts = 10;
  return settings;
}

}  // namespace

void CellService::addNearestFix(const Loaded& loaded, const PlanRequest& request,
                                const TransportProblem& problem, const Deadline& deadline,
                                const OthersWait& others_wait, std::uint64_t most_work,
                                Failed& failed) {
  if (failed.reason == FailureReason::kDeadline || failed.reason == FailureReason::kInternal)
    return;
  const std::vector<ChainHolder>& chain = problem.task.chain;
  if (chain.size() != 2 || chain.front().robot == chain.back().robot) {
    failed.explanation.fix_text = "Not sought: fixes are sought for two holders of two robots.";
    return;
  }
  const SceneRobot& moved_robot = problem.scene->robots[chain.back().robot];
  if (!lastMatters(failed, moved_robot.name)) {
    failed.explanation.fix_text = "No move of " + moved_robot.name + " would help.";
    return;
  }
  const auto withChange = [&](const Override& change) {
    PlanRequest moved = request;
    moved.overrides.push_back(change);
    moved.mode = SearchMode::kFirst;
    return moved;
  };
  FixQuestions questions;
  questions.promise = [&](const Override& change) -> std::size_t {
    const auto instance = loaded.cell.instantiate(withChange(change).overrides, loaded.revision);
    if (!std::holds_alternative<Cell::Instance>(instance)) return 0;
    TransportProblem moved = problem;  // its bodies, maps and grasps: a move changes none of them
    std::vector<Fault> none;
    moved.task = resolveTask(request, std::get<Cell::Instance>(instance), none);
    moved.scene = startOf(std::get<Cell::Instance>(instance).scene, moved.task);
    return commonPoints(moved);
  };
  questions.plans = [&](const Override& change, std::uint64_t& work) {
    auto moved = problemOf(loaded, withChange(change), deadline, Missing::kMake);
    auto* quick = std::get_if<TransportProblem>(&moved);
    if (quick == nullptr) return false;
    quick->settings = quickSearch(quick->settings);
    NullSink null_sink;
    SearchEffort effort;
    const Outcome outcome = planTransport(*quick, null_sink, deadline, &effort);
    work += effort.work();
    return std::holds_alternative<Done>(outcome);
  };
  questions.stop = [&]() -> std::string {
    if (deadline.over()) return "the deadline passed";
    return others_wait() ? "others waited" : "";
  };
  const auto moves = movesByCost(moved_robot.X_WB.translation(), reachBalls(problem, chain.back()),
                                 reachBalls(problem, chain.front()), kMostMapLooks, deadline);
  NearestFix fix = findNearestFix(moved_robot, moves, questions, most_work);
  failed.explanation.nearest_fix = std::move(fix.overrides);
  failed.explanation.fix_text = std::move(fix.text);
}

}  // namespace handover
