// SPDX-License-Identifier: Apache-2.0
#include "core/grasp/grasp_maker.hpp"
#include "core/grasp/object_surface.hpp"
#include "core/grasp/thinning.hpp"

#include <algorithm>
#include <cmath>

namespace handover {
namespace {

constexpr double kWeakShare = 0.1;  // of the best quality; weaker ones only for want of others

bool better(const Grasp& a, const Grasp& b) { return a.quality > b.quality; }

/// `wanted` of the full grasps that are not weak, spread out; where those are too few, the
/// best of the others too.
std::vector<Grasp> chosen(std::vector<Grasp> full, std::vector<Grasp> others, int wanted) {
  double best = 0;
  for (const Grasp& grasp : full) best = std::max(best, grasp.quality);
  const auto weak = std::stable_partition(full.begin(), full.end(), [&](const Grasp& grasp) {
    return grasp.quality >= kWeakShare * best;
  });
  std::stable_sort(others.begin(), others.end(), better);
  others.insert(others.begin(), weak, full.end());
  std::stable_sort(others.begin(), others.begin() + (full.end() - weak), better);
  full.erase(weak, full.end());
  const auto missing =
      static_cast<std::size_t>(wanted) - std::min<std::size_t>(full.size(), wanted);
  full.insert(full.end(), others.begin(),
              others.begin() + static_cast<std::ptrdiff_t>(std::min(missing, others.size())));
  return thin(full, wanted);
}

std::optional<Error> stopped(const Deadline& deadline) {
  switch (deadline.state()) {
    case Deadline::State::kCancelled:
      return Error{ErrorCode::kCancelled, "cancelled while making grasps"};
    case Deadline::State::kPassed:
      return Error{ErrorCode::kDeadline, "deadline passed while making grasps"};
    case Deadline::State::kOpen:
      break;
  }
  return std::nullopt;
}

std::optional<Error> faultOf(const SceneObject& object, const RobotModel& model, ArmId arm,
                             const GraspParams& params) {
  const auto bad = [](std::string detail) {
    return Error{ErrorCode::kInvalidInput, std::move(detail)};
  };
  if (object.shapes.empty()) return bad("object " + object.name + " has no shapes");
  if (!arm.valid() || std::size_t{arm} >= model.arms.size())
    return bad(model.name + " has no arm " + std::to_string(arm.value()));
  const Arm& a = model.arms[arm];
  if (!a.hand.valid()) return bad("arm " + a.name + " of " + model.name + " has no hand");
  if (params.wanted < 1 || params.rolls < 1)
    return bad("wanted and rolls of a grasp set must be positive");
  if (!(params.surplus >= 1) || !(params.friction > 0) || !(params.palm_gap >= 0)) {
    return bad("surplus of a grasp set must be >= 1, friction > 0, palm_gap >= 0");
  }
  if (!(params.seal_bend > 0) || !(params.holding > 0)) {
    return bad("seal_bend and holding of a grasp set must be > 0");
  }
  return std::nullopt;
}

}  // namespace

Result<GraspSet> generateGrasps(const SceneObject& object, const RobotModel& model, ArmId arm,
                                const GraspParams& params,
                                const std::function<void(double)>& progress,
                                const Deadline& deadline) {
  if (auto fault = faultOf(object, model, arm, params)) return *fault;
  SamplingParams sampling;
  sampling.seed = params.seed;
  const std::vector<SurfaceSample> samples = sampleSurface(ObjectSurface(object), sampling);
  const Arm& a = model.arms[arm];
  GraspSet set;
  set.object = object.name;
  set.robot = model.name;
  set.hand = model.hands[a.hand].name;
  if (samples.empty()) {
    set.none_because = "it has no exposed surface";
    return set;
  }
  HandModel hand = extractEndEffector(model, arm);
  const auto make = hand.hand.suction ? makeSuctionGrasps : makeFingerGrasps;
  const std::unique_ptr<GraspMaker> maker = make(object, std::move(hand), params, samples);
  const auto enough = static_cast<std::size_t>(std::ceil(params.surplus * params.wanted));
  std::vector<Grasp> full,
      partial;  // as good as can be asked for, or less
  const auto known = [&](const Grasp& grasp, const std::vector<Grasp>& grasps) {
    return std::any_of(grasps.begin(), grasps.end(), [&](const Grasp& other) {
      return tooClose(grasp, other, params.min_spacing, params.min_angle);
    });
  };
  // Samples come in farthest-point order: wherever we stop, they are even over the surface.
  for (std::size_t s = 0; s < samples.size() && full.size() < enough; ++s) {
    if (auto error = stopped(deadline)) return *error;
    for (Grasp& grasp : maker->graspsAt(samples[s])) {
      if (known(grasp, full) || known(grasp, partial)) continue;
      (maker->isFull(grasp) ? full : partial).push_back(std::move(grasp));
    }
    if (progress) {
      progress(
          std::max(static_cast<double>(s + 1) / static_cast<double>(samples.size()),
                   std::min(1.0, static_cast<double>(full.size()) / static_cast<double>(enough))));
    }
  }
  set.grasps = chosen(std::move(full), std::move(partial), params.wanted);
  if (set.grasps.empty()) set.none_because = maker->whyNone();
  std::stable_sort(set.grasps.begin(), set.grasps.end(), better);
  return set;
}

}  // namespace handover
