// SPDX-License-Identifier: Apache-2.0
#include "runtime/cell_service.hpp"

#include "core/collision/arm_self_collision.hpp"
#include "core/handover/cell_state.hpp"
#include "runtime/nearest_fix.hpp"
#include "runtime/parts_cache.hpp"
#include "settings/roots.hpp"

#include <handover/common/log.hpp>

#include <cstdio>
#include <set>
#include <stdexcept>

namespace handover {
namespace {

std::string hexText(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

GraspParams graspParams(const SceneObject& object, const SceneRobot& robot, const Hand& hand) {
  GraspParams params;
  if (const auto by_robot = object.grasp_counts.find(robot.name);
      by_robot != object.grasp_counts.end()) {
    if (const auto count = by_robot->second.find(hand.name); count != by_robot->second.end()) {
      params.wanted = count->second;
    }
  }
  return params;
}

/// Products kept in memory of each sort, and how often one who waits for another's looks at its
/// deadline.
constexpr std::size_t kKept = 256;
constexpr std::chrono::milliseconds kDeadlineCheck{20};

/// For plans that are only asked whether they exist.
class SilentSink : public StageSink {
 public:
  void emit(StagePayload) override {}
};

/// Whether where the receiver stands can have to do with a failure: what the giver alone cannot do
/// no move of the receiver helps, unless it is in the way.
bool receiverMatters(const Failed& failed, const SceneTask& task) {
  const auto inTheWay = [&] {
    for (const auto& cause : failed.explanation.causes) {
      for (const auto& body : {cause.pair.first, cause.pair.second}) {
        if (body.starts_with(task.receiver + "/")) return true;
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
    case FailureReason::kDeadline:
    case FailureReason::kInternal:
      return false;
  }
  return false;
}

Rejected badRequest(std::vector<Fault> faults) { return {"bad_request", std::move(faults)}; }

/// The task of a request: named, or made from object, goal and robots. Faults when names are
/// unknown.
SceneTask resolveTask(const PlanRequest& request, const Cell::Instance& instance,
                      std::vector<Fault>& faults) {
  if (!request.task.empty() || request.object.empty()) {
    for (const auto& task : instance.tasks) {
      if (request.task.empty() || task.name == request.task) return task;
    }
    faults.push_back({"task", "the cell has no task '" + request.task + "'"});
    return {};
  }
  const Scene& scene = *instance.scene;
  SceneTask task;
  task.object = request.object;
  task.giver = request.giver;
  task.receiver = request.receiver;
  if (const int object = scene.findObject(request.object); object >= 0) {
    task.X_WO_start = scene.objects[static_cast<std::size_t>(object)].X_WO;
  } else {
    faults.push_back({"object_name", "the cell has no object '" + request.object + "'"});
  }
  if (scene.findRobot(request.giver) < 0) {
    faults.push_back({"giver", "the cell has no robot '" + request.giver + "'"});
  }
  if (scene.findRobot(request.receiver) < 0) {
    faults.push_back({"receiver", "the cell has no robot '" + request.receiver + "'"});
  }
  if (request.giver == request.receiver) {
    faults.push_back({"receiver", "giver and receiver are the same robot"});
  }
  if (request.X_WO_goal) {
    task.X_WO_goal = toPose(*request.X_WO_goal);
  } else {
    faults.push_back({"X_WO_goal", "a request without a task needs a goal pose"});
  }
  return task;
}

void checkArm(const Scene& scene, const std::string& robot, const std::string& arm,
              const char* field, std::vector<Fault>& faults) {
  if (arm.empty()) return;
  const int index = scene.findRobot(robot);
  if (index < 0) return;  // a fault already
  if (scene.robots[static_cast<std::size_t>(index)].model->findArm(arm) < 0) {
    faults.push_back({field, "robot '" + robot + "' has no arm '" + arm + "'"});
  }
}

}  // namespace

ResourceCache::ResourceCache(std::filesystem::path folder, Progress progress, bool force)
    : folder_(std::move(folder)), progress_(std::move(progress)), force_(force) {}

std::shared_ptr<const ArmKinematics> ResourceCache::kinematics(
    const std::shared_ptr<const RobotModel>& model, int arm) {
  const MutexLock lock(mutex_);
  auto& entry = kinematics_[{model.get(), arm}];
  if (!entry) entry = std::make_shared<const ArmKinematics>(*model, arm);
  return entry;
}

template <typename Product, typename Make>
std::shared_ptr<const Product> ResourceCache::get(Shelf<Product>& shelf, std::uint64_t hash,
                                                  const Deadline& deadline, Make make) {
  MutexLock lock(mutex_);
  while (true) {
    if (const auto known = shelf.products.find(hash); known != shelf.products.end()) {
      return known->second;
    }
    if (!shelf.in_the_making.contains(hash)) break;
    if (deadline.over()) throw std::runtime_error("stopped while another request made it");
    made_.wait_for(lock, kDeadlineCheck);
  }
  shelf.in_the_making.insert(hash);
  lock.unlock();
  std::shared_ptr<const Product> product;
  std::exception_ptr failure;
  try {
    product = make();
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  shelf.in_the_making.erase(hash);
  if (!failure) {
    // Requests that change robots or objects bring products of their own; the folder keeps them
    // all.
    if (shelf.products.size() >= kKept) shelf.products.clear();
    shelf.products[hash] = product;
  }
  made_.notify_all();
  if (failure) std::rethrow_exception(failure);
  return product;
}

std::shared_ptr<const ReachabilityMap> ResourceCache::map(const SceneRobot& robot, int arm,
                                                          const Deadline& deadline) {
  const std::uint64_t hash =
      ReachabilityMap::hash(*robot.model, arm, robot.q_start, ReachabilityParams{});
  return get(maps_, hash, deadline, [&] { return makeMap(robot, arm, hash, deadline); });
}

std::shared_ptr<const ReachabilityMap> ResourceCache::makeMap(const SceneRobot& robot, int arm,
                                                              std::uint64_t hash,
                                                              const Deadline& deadline) {
  const ReachabilityParams params;
  const std::string arm_name =
      robot.model->name + "/" + robot.model->arms[static_cast<std::size_t>(arm)].name;
  const auto file =
      folder_ / "maps" /
      (robot.model->name + "-" + robot.model->arms[static_cast<std::size_t>(arm)].name + "-" +
       hexText(hash) + ".map");
  auto log = logger("maps");
  if (!force_) {
    auto map = ReachabilityMap::open(file, hash);
    if (map) return *map;
    if (map.error().code != ErrorCode::kNotFound) {
      log->warn("{}; it is made again", map.error().detail);
    }
  }
  std::filesystem::create_directories(file.parent_path());
  const ArmSelfCollision touches_itself(*robot.model, arm, robot.q_start);
  const auto built = ReachabilityMap::build(
      *robot.model, arm, robot.q_start, params,
      [&](const ArmVector& q) { return touches_itself(q); }, file,
      [&](double fraction) {
        if (progress_) progress_("map " + arm_name, fraction);
      },
      deadline);
  if (!built) throw std::runtime_error("map of " + arm_name + ": " + built.error().detail);
  auto map = ReachabilityMap::open(file, hash);
  if (!map) throw std::runtime_error("map of " + arm_name + ": " + map.error().detail);
  return *map;
}

std::shared_ptr<const GraspSet> ResourceCache::grasps(const SceneObject& object,
                                                      const SceneRobot& robot, int arm,
                                                      const Deadline& deadline) {
  const int hand = robot.model->arms[static_cast<std::size_t>(arm)].hand;
  if (hand < 0) return nullptr;
  const GraspParams params =
      graspParams(object, robot, robot.model->hands[static_cast<std::size_t>(hand)]);
  const std::uint64_t hash = graspSetHash(object, *robot.model, arm, params);
  return get(grasps_, hash, deadline,
             [&] { return makeGrasps(object, robot, arm, hash, deadline); });
}

std::shared_ptr<const GraspSet> ResourceCache::makeGrasps(const SceneObject& object,
                                                          const SceneRobot& robot, int arm,
                                                          std::uint64_t hash,
                                                          const Deadline& deadline) {
  const Hand& hand =
      robot.model
          ->hands[static_cast<std::size_t>(robot.model->arms[static_cast<std::size_t>(arm)].hand)];
  const GraspParams params = graspParams(object, robot, hand);
  const std::string name = object.name + " " + robot.model->name + "/" + hand.name;
  const auto file =
      folder_ / "grasps" /
      (object.name + "-" + robot.model->name + "-" + hand.name + "-" + hexText(hash) + ".json");
  auto log = logger("grasps");
  if (!force_) {
    auto set = readGraspSet(file, hash);
    if (set) return std::make_shared<const GraspSet>(std::move(*set));
    if (set.error().code != ErrorCode::kNotFound) {
      log->warn("{}; it is made again", set.error().detail);
    }
  }
  std::filesystem::create_directories(file.parent_path());
  auto set = generateGrasps(
      object, *robot.model, arm, params,
      [&](double fraction) {
        if (progress_) progress_("grasps " + name, fraction);
      },
      deadline);
  if (!set) {
    if (set.error().code == ErrorCode::kNotFound) return nullptr;
    throw std::runtime_error("grasps of " + name + ": " + set.error().detail);
  }
  if (const auto written = writeGraspSet(*set, hash, file); !written) {
    throw std::runtime_error("grasps of " + name + ": " + written.error().detail);
  }
  return std::make_shared<const GraspSet>(std::move(*set));
}

CellService::CellService(const std::filesystem::path& root, const std::vector<std::string>& cells,
                         const std::filesystem::path& cache_folder,
                         ResourceCache::Progress progress, bool force)
    : cache_(cache_folder, std::move(progress), force) {
  const PartsCache divide(cache_folder, force);
  std::vector<FileFault> faults;
  for (const auto& name : cells) {
    const auto file = cellFile(name, root);
    Cell cell = Cell::load(file, root, models_, divide);
    if (find(cell.name()) != nullptr) {
      faults.push_back({file.string(), 0, "a cell named '" + cell.name() + "' is loaded already"});
      continue;
    }
    auto instance = cell.instantiate({}, 1);
    if (auto* found = std::get_if<std::vector<Fault>>(&instance)) {
      for (const auto& fault : *found) {
        faults.push_back({file.string(), 0, fault.field + ": " + fault.message});
      }
      continue;
    }
    Loaded loaded{std::move(cell), std::get<Cell::Instance>(std::move(instance)), {}, 1};
    for (const auto& task : loaded.instance.tasks) {
      auto& collision = loaded.collision[task.object];
      if (!collision) collision = collisionForTask(*loaded.instance.scene, task.object);
    }
    cells_.push_back(std::move(loaded));
  }
  if (!faults.empty()) throw FileError(std::move(faults));
}

const CellService::Loaded* CellService::find(const std::string& cell) const {
  for (const auto& loaded : cells_) {
    if (loaded.cell.name() == cell) return &loaded;
  }
  return nullptr;
}

std::vector<CellInfo> CellService::cells() const {
  std::vector<CellInfo> infos;
  for (const auto& loaded : cells_) {
    infos.push_back(
        {loaded.cell.name(), loaded.cell.taskNames(), loaded.revision, loaded.cell.variations()});
  }
  return infos;
}

void CellService::prepare(const Deadline& deadline) {
  for (const auto& loaded : cells_) {
    std::set<std::string> objects;
    for (const auto& task : loaded.instance.tasks) objects.insert(task.object);
    for (const auto& object : objects) resources(*loaded.instance.scene, object, deadline);
  }
}

std::vector<RobotResources> CellService::resources(const Scene& scene, const std::string& object,
                                                   const Deadline& deadline) {
  const SceneObject& target = scene.objects[static_cast<std::size_t>(scene.findObject(object))];
  std::vector<RobotResources> all;
  for (const auto& robot : scene.robots) {
    RobotResources mine;
    for (int arm = 0; arm < static_cast<int>(robot.model->arms.size()); ++arm) {
      mine.kinematics.push_back(cache_.kinematics(robot.model, arm));
      mine.maps.push_back(cache_.map(robot, arm, deadline));
      mine.grasps.push_back(cache_.grasps(target, robot, arm, deadline));
    }
    all.push_back(std::move(mine));
  }
  return all;
}

std::variant<HandoverProblem, Outcome> CellService::problemOf(const Loaded& loaded,
                                                              const PlanRequest& request,
                                                              const Deadline& deadline) {
  Cell::Instance instance = loaded.instance;
  std::vector<Fault> faults;
  if (!request.overrides.empty()) {
    auto changed = loaded.cell.instantiate(request.overrides, loaded.revision);
    if (auto* found = std::get_if<std::vector<Fault>>(&changed)) {
      faults = std::move(*found);  // the rest is checked against the cell as it is
    } else {
      instance = std::get<Cell::Instance>(std::move(changed));
    }
  }

  HandoverProblem problem;
  problem.scene = instance.scene;
  problem.task = resolveTask(request, instance, faults);
  checkArm(*instance.scene, problem.task.giver, request.giver_arm, "giver_arm", faults);
  checkArm(*instance.scene, problem.task.receiver, request.receiver_arm, "receiver_arm", faults);
  if (!faults.empty()) return badRequest(std::move(faults));
  problem.scene = startOf(instance.scene, problem.task);

  const auto known = loaded.collision.find(problem.task.object);
  problem.collision = request.overrides.empty() && known != loaded.collision.end()
                          ? known->second
                          : collisionForTask(*problem.scene, problem.task.object);
  try {
    problem.resources = resources(*instance.scene, problem.task.object, deadline);
  } catch (const std::runtime_error& error) {
    // Maps and grasps of a changed robot or object take long to make.
    if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
    if (deadline.state() == Deadline::State::kOpen) throw;
    Failed late;
    late.reason = FailureReason::kDeadline;
    late.explanation.filter = "prepare";
    late.explanation.text =
        std::string("The deadline passed while maps and grasps were made: ") + error.what();
    return late;
  }
  problem.giver_arm = request.giver_arm;
  problem.receiver_arm = request.receiver_arm;
  problem.mode = request.mode;
  problem.search = request.search;
  problem.seed = request.seed;
  problem.speed_scale = request.speed_scale;
  return problem;
}

std::variant<HandoverProblem, Outcome> CellService::problemOf(const PlanRequest& request,
                                                              const Deadline& deadline) {
  const Loaded* loaded = find(request.cell);
  if (loaded == nullptr)
    return Rejected{"unknown_cell", {{"cell", "no cell '" + request.cell + "'"}}};
  if (request.expected_revision && *request.expected_revision != loaded->revision) {
    return Rejected{
        "scene_changed",
        {{"expected_revision", "the scene's revision is " + std::to_string(loaded->revision)}}};
  }
  return problemOf(*loaded, request, deadline);
}

Outcome CellService::plan(const PlanRequest& request, StageSink& sink, const Deadline& deadline) {
  auto problem = problemOf(request, deadline);
  if (auto* refused = std::get_if<Outcome>(&problem)) return std::move(*refused);
  Outcome outcome = planHandover(std::get<HandoverProblem>(problem), sink, deadline);
  if (auto* failed = std::get_if<Failed>(&outcome)) {
    // Mode first is for those who want an answer soon.
    if (request.mode != SearchMode::kFirst) {
      addNearestFix(*find(request.cell), request, std::get<HandoverProblem>(problem), deadline,
                    *failed);
    }
    if (deadline.state() == Deadline::State::kCancelled) return Cancelled{};
  }
  return outcome;
}

void CellService::addNearestFix(const Loaded& loaded, const PlanRequest& request,
                                const HandoverProblem& problem, const Deadline& deadline,
                                Failed& failed) {
  if (failed.reason == FailureReason::kDeadline || failed.reason == FailureReason::kInternal)
    return;
  if (!receiverMatters(failed, problem.task)) {
    failed.explanation.fix_text = "No move of " + problem.task.receiver + " would help.";
    return;
  }
  const int giver = problem.scene->findRobot(problem.task.giver);
  const int receiver = problem.scene->findRobot(problem.task.receiver);
  const SceneRobot& moved_robot = problem.scene->robots[static_cast<std::size_t>(receiver)];
  const auto withChange = [&](const Override& change) {
    PlanRequest moved = request;
    moved.overrides.push_back(change);
    moved.mode = SearchMode::kFirst;
    return moved;
  };
  const auto maps_allow = [&](const Override& change) {
    const auto instance = loaded.cell.instantiate(withChange(change).overrides, loaded.revision);
    if (!std::holds_alternative<Cell::Instance>(instance)) return false;
    HandoverProblem moved = problem;  // its bodies, maps and grasps: a move changes none of them
    std::vector<Fault> none;
    moved.task = resolveTask(request, std::get<Cell::Instance>(instance), none);
    moved.scene = startOf(std::get<Cell::Instance>(instance).scene, moved.task);
    return mapsAllow(moved);
  };
  const auto plans = [&](const Override& change) {
    auto moved = problemOf(loaded, withChange(change), deadline);
    if (!std::holds_alternative<HandoverProblem>(moved)) return false;
    SilentSink unheard;
    const Outcome outcome = planHandover(std::get<HandoverProblem>(moved), unheard, deadline);
    return std::holds_alternative<Done>(outcome);
  };
  const auto moves = movesByCost(moved_robot.X_WB.translation(),
                                 reachBalls(problem, receiver, problem.receiver_arm),
                                 reachBalls(problem, giver, problem.giver_arm));
  NearestFix fix = findNearestFix(moved_robot, moves, maps_allow, plans, deadline);
  failed.explanation.nearest_fix = std::move(fix.overrides);
  failed.explanation.fix_text = std::move(fix.text);
}

}  // namespace handover
