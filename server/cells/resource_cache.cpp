// SPDX-License-Identifier: Apache-2.0
#include "cells/resource_cache.hpp"

#include "core/collision/arm_self_collision.hpp"

#include <handover/common/log.hpp>

#include <cstdio>
#include <deque>
#include <stdexcept>

namespace handover {
namespace {

std::string hexText(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

/// What was made of an arm's map, for the log.
std::string lineOf(const RobotModel& model, std::size_t arm, const MapReport& report) {
  std::string line = model.name + "/" + model.arms[arm].name + ": ";
  if (report.image_of >= 0) {
    line += "the mirror image of " + model.arms[static_cast<std::size_t>(report.image_of)].name;
  } else {
    line += "a map of its own";
    if (!report.why_own.empty()) line += " (" + report.why_own + ")";
  }
  line += ", " + std::to_string(report.accepted) + " samples, " + std::to_string(report.near_ties) +
          " voxels near a tie of two arms";
  if (report.near_ties_short > 0) {
    line += ", " + std::to_string(report.near_ties_short) + " of them with fewer than " +
            std::to_string(ReachabilityParams{}.tie_samples) + " samples";
  }
  return line;
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

/// A set that is short of grasps, and one that has none, are said.
void tellOf(const GraspSet& set, const std::string& name, int wanted) {
  const auto log = logger("grasps");
  if (set.grasps.empty()) {
    log->warn("{}: none: {}", name, set.none_because);
  } else if (static_cast<int>(set.grasps.size()) < wanted) {
    log->info("{}: {} of the {} wanted", name, set.grasps.size(), wanted);
  }
}

/// Products kept in memory of each sort, and how often one who waits for another's looks at its
/// deadline.
constexpr std::size_t kKept = 256;
constexpr std::chrono::milliseconds kDeadlineCheck{20};

}  // namespace

ResourceCache::ResourceCache(std::filesystem::path folder, Progress progress, bool force)
    : folder_(std::move(folder)), progress_(std::move(progress)), force_(force) {}

std::shared_ptr<const ArmKinematics> ResourceCache::kinematics(
    const std::shared_ptr<const RobotModel>& model, ArmId arm) {
  const MutexLock lock(mutex_);
  std::erase_if(kinematics_, [](const auto& known) { return known.second.model.expired(); });
  auto& entry = kinematics_[{model.get(), arm}];
  if (!entry.kinematics) {
    entry = {model, std::make_shared<const ArmKinematics>(*model, arm)};
  }
  return entry.kinematics;
}

template <typename Product, typename Make>
std::shared_ptr<const Product> ResourceCache::get(Shelf<Product>& shelf, std::uint64_t hash,
                                                  const Deadline& deadline, Missing missing,
                                                  Make make) {
  MutexLock lock(mutex_);
  while (true) {
    if (const auto known = shelf.products.find(hash); known != shelf.products.end()) {
      return known->second;
    }
    if (missing == Missing::kThrow) throw NotPrepared("not in memory");
    if (!shelf.in_progress.contains(hash)) break;
    if (deadline.over()) throw std::runtime_error("stopped while another request made it");
    made_.wait_for(lock, kDeadlineCheck);
  }
  shelf.in_progress.insert(hash);
  lock.unlock();
  std::shared_ptr<const Product> product;
  std::exception_ptr failure;
  try {
    product = make();
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  shelf.in_progress.erase(hash);
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

std::shared_ptr<const ReachabilityMap> ResourceCache::map(const SceneRobot& robot, ArmId arm,
                                                          const Deadline& deadline,
                                                          Missing missing) {
  // Each arm's hash covers them all.
  const std::uint64_t hash =
      ReachabilityMap::hash(*robot.model, ArmId(0), robot.q_start, ReachabilityParams{});
  const auto maps = get(maps_, hash, deadline, missing, [&] {
    const std::vector<MapFile> files = mapFiles(robot);
    if (auto kept = force_ ? nullptr : readMaps(files)) return kept;
    makeMaps(robot, files, deadline);
    if (auto made = readMaps(files)) return made;
    throw std::runtime_error("maps of " + robot.model->name + ": gone as soon as made");
  });
  return maps->at(arm);
}

std::vector<ResourceCache::MapFile> ResourceCache::mapFiles(const SceneRobot& robot) const {
  std::vector<MapFile> files;
  for (const Arm& arm : robot.model->arms) {
    const std::uint64_t hash = ReachabilityMap::hash(*robot.model, ArmId(files.size()),
                                                     robot.q_start, ReachabilityParams{});
    files.push_back(
        {folder_ / "maps" / (robot.model->name + "-" + arm.name + "-" + hexText(hash) + ".map"),
         hash});
  }
  return files;
}

std::shared_ptr<const ResourceCache::RobotMaps> ResourceCache::readMaps(
    const std::vector<MapFile>& files) {
  auto maps = std::make_shared<RobotMaps>();
  for (const MapFile& file : files) {
    auto map = ReachabilityMap::open(file.path, file.hash);
    if (!map) {
      if (map.error().code != ErrorCode::kNotFound) {
        logger("maps")->warn("{}; rebuilding", map.error().detail);
      }
      return nullptr;
    }
    maps->push_back(*map);
  }
  return maps;
}

void ResourceCache::makeMaps(const SceneRobot& robot, const std::vector<MapFile>& files,
                             const Deadline& deadline) {
  const RobotModel& model = *robot.model;
  std::vector<std::filesystem::path> paths;
  std::deque<ArmSelfCollision> arms;
  std::vector<ReachabilityMap::SelfCollision> touch;
  for (const MapFile& file : files) {
    auto& arm = arms.emplace_back(model, ArmId(paths.size()), robot.q_start);
    touch.emplace_back([&arm](const ArmVector& q) { return arm.touches(q); });
    paths.push_back(file.path);
  }
  const auto reports = ReachabilityMap::build(
      model, robot.q_start, ReachabilityParams{}, touch, paths,
      [&](double fraction) {
        if (progress_) progress_("maps " + model.name, fraction);
      },
      deadline);
  if (!reports) throw std::runtime_error("maps of " + model.name + ": " + reports.error().detail);
  for (std::size_t arm = 0; arm < reports->size(); ++arm) {
    logger("maps")->info("{}", lineOf(model, arm, (*reports)[arm]));
  }
}

std::shared_ptr<const GraspSet> ResourceCache::grasps(const SceneObject& object,
                                                      const SceneRobot& robot, ArmId arm,
                                                      const Deadline& deadline, Missing missing) {
  const HandId hand = robot.model->arms[arm].hand;
  if (!hand.valid()) return nullptr;
  const GraspParams params = graspParams(object, robot, robot.model->hands[hand]);
  const std::uint64_t hash = graspSetHash(object, *robot.model, arm, params);
  return get(grasps_, hash, deadline, missing,
             [&] { return makeGrasps(object, robot, arm, hash, deadline); });
}

std::shared_ptr<const GraspSet> ResourceCache::makeGrasps(const SceneObject& object,
                                                          const SceneRobot& robot, ArmId arm,
                                                          std::uint64_t hash,
                                                          const Deadline& deadline) {
  const Hand& hand = robot.model->hands[robot.model->arms[arm].hand];
  const GraspParams params = graspParams(object, robot, hand);
  const std::string name = object.name + " " + robot.model->name + "/" + hand.name;
  const auto file =
      folder_ / "grasps" /
      (object.name + "-" + robot.model->name + "-" + hand.name + "-" + hexText(hash) + ".json");
  auto log = logger("grasps");
  if (!force_) {
    auto set = readGraspSet(file, hash);
    if (set) {
      tellOf(*set, name, params.wanted);
      return std::make_shared<const GraspSet>(std::move(*set));
    }
    if (set.error().code != ErrorCode::kNotFound) {
      log->warn("{}; rebuilding", set.error().detail);
    }
  }
  std::filesystem::create_directories(file.parent_path());
  auto set = generateGrasps(
      object, *robot.model, arm, params,
      [&](double fraction) {
        if (progress_) progress_("grasps " + name, fraction);
      },
      deadline);
  if (!set) throw std::runtime_error("grasps of " + name + ": " + set.error().detail);
  if (const auto written = writeGraspSet(*set, hash, file); !written) {
    throw std::runtime_error("grasps of " + name + ": " + written.error().detail);
  }
  tellOf(*set, name, params.wanted);
  return std::make_shared<const GraspSet>(std::move(*set));
}

}  // namespace handover
