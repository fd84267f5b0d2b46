// SPDX-License-Identifier: Apache-2.0
#include "core/reachability/map_sampler.hpp"

#include <handover/common/random.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace handover::reachability {
namespace {

// Samples between two looks at the deadline: some ms, self-collision tests included.
constexpr std::uint64_t kBlock = 512;
// Images share a map when of so many samples at most this part touches on one side only.
constexpr std::uint64_t kPilot = 20'000;
constexpr double kMostDisagreement = 0.02;
// Extra samples: the first joint goes round for each draw of the others, so many steps; so many
// draws in a pass. After each pass many a tie is decided, and needs no more.
constexpr int kRing = 32;
constexpr std::uint64_t kRings = 100'000;
constexpr std::uint64_t kPasses = 24;
// Voxels with fewer samples say too little about how samples scatter.
constexpr std::uint32_t kEnoughForDeviation = 20;

std::optional<Error> stopped(const Deadline& deadline) {
  if (!deadline.over()) return std::nullopt;
  if (deadline.state() == Deadline::State::kPassed) {
    return Error{ErrorCode::kDeadline, "the deadline passed while maps were built"};
  }
  return Error{ErrorCode::kCancelled, "cancelled while maps were built"};
}

/// Root mean square of (deviation / mean) over the voxels.
double relativeDeviation(const VoxelGatherer& gatherer) {
  double sum = 0;
  std::size_t voxels = 0;
  for (const Gathered& voxel : gatherer.voxels()) {
    if (voxel.samples < kEnoughForDeviation || !(voxel.mean() > 0)) continue;
    sum += voxel.variance() / (voxel.mean() * voxel.mean());
    ++voxels;
  }
  return voxels == 0 ? 1 : std::sqrt(sum / static_cast<double>(voxels));
}

/// An arm's first joint going round in even steps over its range, in A: all else of the arm goes
/// with it as one.
std::vector<Pose> roundOf(const Joint& joint, double range) {
  std::vector<Pose> moves;
  for (int step = 0; step < kRing; ++step) {
    const double by = range * step / kRing;
    Pose along = Pose::Identity();
    if (joint.type == JointType::kRevolute) {
      along.linear() = Eigen::AngleAxisd(by, joint.axis).toRotationMatrix();
    } else {
      along.translation() = by * joint.axis;
    }
    moves.push_back(joint.X_PJ * along * joint.X_PJ.inverse());
  }
  return moves;
}

/// Which rounds of the first joint can come to a wanted voxel: by the tool's distance from its axis
/// and its height along it, which stay as they are all round. A sliding joint's: any.
class RoundFilter {
 public:
  RoundFilter(const Joint& joint, double reach, double voxel)
      : turns_(joint.type == JointType::kRevolute),
        origin_(joint.X_PJ.translation()),
        axis_(joint.X_PJ.linear() * joint.axis),
        voxel_(voxel),
        half_(static_cast<int>(2 * reach / voxel) + 4),
        cells_(static_cast<std::size_t>(2 * half_) * static_cast<std::size_t>(half_), false) {}

  void want(const Eigen::Vector3d& centre) {
    const auto [distance, height] = placeOf(centre);
    // Half of a voxel's diagonal is less than an edge.
    for (int d = -1; d <= 1; ++d) {
      for (int h = -1; h <= 1; ++h) {
        const int cell = cellAt(distance + d, height + h);
        if (cell >= 0) cells_[static_cast<std::size_t>(cell)] = true;
      }
    }
  }

  bool mayHit(const Eigen::Vector3d& p_A) const {
    if (!turns_) return true;
    const auto [distance, height] = placeOf(p_A);
    const int cell = cellAt(distance, height);
    return cell >= 0 && cells_[static_cast<std::size_t>(cell)];
  }

 private:
  /// In edges, rounded down.
  std::pair<int, int> placeOf(const Eigen::Vector3d& p_A) const {
    const Eigen::Vector3d p = p_A - origin_;
    const double height = axis_.dot(p);
    return {static_cast<int>(std::sqrt(std::max(0.0, p.squaredNorm() - height * height)) / voxel_),
            static_cast<int>(std::floor(height / voxel_))};
  }

  int cellAt(int distance, int height) const {
    if (distance < 0 || distance >= half_ || height < -half_ || height >= half_) return -1;
    return (height + half_) * half_ + distance;
  }

  bool turns_;
  Eigen::Vector3d origin_, axis_;
  double voxel_;
  int half_;
  std::vector<bool> cells_;
};

}  // namespace

MapSampler::MapSampler(const RobotModel& model, const RobotVector& q_torso,
                       const ReachabilityParams& params,
                       const std::vector<ReachabilityMap::SelfCollision>& self_collision,
                       std::vector<ArmKinematics> arms)
    : model_(model),
      params_(params),
      self_collision_(self_collision),
      arms_(std::move(arms)),
      seats_(arms_.size()) {
  std::vector<Pose> X_BL;
  linkPoses(model, Pose::Identity(), q_torso, X_BL);
  for (std::size_t arm = 0; arm < arms_.size(); ++arm) {
    seats_[arm].X_BA = X_BL[model.arms[arm].base_link];
    for (std::size_t family = 0; family < families_.size(); ++family) {
      std::vector<Member>& members = families_[family].members;
      const auto mirror = findArmMirror(model, ArmId(members.front().arm), ArmId(arm), q_torso);
      Member image{arm, std::nullopt};
      if (mirror) image.mirror = *mirror;
      seats_[arm].why_own =
          mirror ? shapesDiffer(members.front().arm, image) : mirror.error().detail;
      if (!seats_[arm].why_own.empty()) continue;
      seats_[arm].family = family;
      seats_[arm].member = members.size();
      members.push_back(std::move(image));
      break;
    }
    if (arm > 0 && seats_[arm].why_own.empty()) continue;
    seats_[arm].family = families_.size();
    families_.push_back(
        {{{arm, std::nullopt}}, VoxelGatherer(arms_[arm].reach(), params.voxel), 0, 0, {}});
  }
}

bool MapSampler::touches(std::size_t arm, const ArmVector& q) const {
  return !self_collision_.empty() && self_collision_[arm] && self_collision_[arm](q);
}

std::string MapSampler::shapesDiffer(std::size_t arm, const Member& image) const {
  std::uint64_t differing = 0;
  const std::uint64_t pilot = std::min(kPilot, params_.samples);
  for (std::uint64_t sample = 0; sample < pilot; ++sample) {
    const ArmVector q = draw(arm, sample);
    if (touches(arm, q) != touches(image.arm, image.mirror->image(q))) ++differing;
  }
  const double part = static_cast<double>(differing) / static_cast<double>(pilot);
  if (part <= kMostDisagreement) return "";
  char text[120];
  std::snprintf(text, sizeof(text), "%.1f %% of mirrored configurations touch on one side only",
                100 * part);
  return text;
}

/// Sample number `sample`: each joint uniform within its limits, whatever was drawn before.
ArmVector MapSampler::draw(std::size_t arm, std::uint64_t sample) const {
  const ArmKinematics& kinematics = arms_[arm];
  ArmVector q(kinematics.dofs());
  for (int i = 0; i < kinematics.dofs(); ++i) {
    const double fraction = SeededRandom::toUnit(
        SeededRandom::bitsAt(params_.seed, sample * 8 + static_cast<std::uint64_t>(i)));
    q[i] = kinematics.lower()[i] + fraction * (kinematics.upper()[i] - kinematics.lower()[i]);
  }
  return q;
}

MapSample MapSampler::sampleAt(std::size_t arm, const ArmVector& q) const {
  ArmJacobian J;
  const Pose X_AT = arms_[arm].toolPose(q, J);
  return {X_AT.translation(), X_AT.linear() * model_.arms[arm].approach_axis, manipulability(J), q};
}

std::optional<Error> MapSampler::sample(const ReachabilityMap::Progress& progress,
                                        const Deadline& deadline) {
  double before = 0;
  const double share = 1.0 / static_cast<double>(families_.size());
  for (Family& family : families_) {
    const auto done = [&](double part) {
      if (progress) progress(before + share * part);
    };
    if (auto error = sampleAll(family, done, deadline)) return error;
    family.relative_deviation = relativeDeviation(family.gatherer);
    before += share;
  }
  for (std::uint64_t pass = 0; pass < kPasses; ++pass) {
    findNearTies();
    for (Family& family : families_) {
      if (auto error = refine(family, pass, deadline)) return error;
    }
  }
  findNearTies();
  return std::nullopt;
}

std::optional<Error> MapSampler::sampleAll(Family& family, const std::function<void(double)>& done,
                                           const Deadline& deadline) {
  for (std::uint64_t sample = 0; sample < params_.samples; ++sample) {
    if (sample % kBlock == 0) {
      if (auto error = stopped(deadline)) return error;
      done(static_cast<double>(sample) / static_cast<double>(params_.samples));
    }
    const ArmVector q = draw(first(family), sample);
    if (touches(first(family), q)) continue;
    family.gatherer.add(sampleAt(first(family), q));
    ++family.accepted;
  }
  return std::nullopt;
}

std::int32_t MapSampler::voxelAt(std::size_t arm, const Eigen::Vector3d& p_B) const {
  const Seat& seat = seats_[arm];
  const Family& family = families_[seat.family];
  const auto& mirror = family.members[seat.member].mirror;
  const Eigen::Vector3d p_A = seat.X_BA.inverse() * p_B;
  return family.gatherer.find(mirror ? (mirror->S_ToFrom.transpose() * p_A).eval() : p_A);
}

/// Of the voxel's mean. A voxel of few samples that happen to agree gets the map's usual scatter.
double MapSampler::squaredError(const Family& family, const Gathered& voxel) const {
  const double usual = family.relative_deviation * voxel.mean();
  return std::max(voxel.variance(), usual * usual) / voxel.samples;
}

void MapSampler::compare(std::size_t arm, std::size_t other) {
  const Seat& seat = seats_[arm];
  Family &family = families_[seat.family], &rival = families_[seats_[other].family];
  const auto& mirror = family.members[seat.member].mirror;
  for (std::size_t v = 0; v < family.gatherer.voxels().size(); ++v) {
    const Eigen::Vector3d centre = family.gatherer.centre(v);
    const Eigen::Vector3d p_B = seat.X_BA * (mirror ? (mirror->S_ToFrom * centre).eval() : centre);
    const std::int32_t w = voxelAt(other, p_B);
    if (w < 0) continue;
    const Gathered& a = family.gatherer.voxels()[v];
    const Gathered& b = rival.gatherer.voxels()[static_cast<std::size_t>(w)];
    const double difference = a.mean() - b.mean();
    const double error = squaredError(family, a) + squaredError(rival, b);
    if (difference * difference > params_.tie_errors * params_.tie_errors * error) continue;
    family.near_tie[v] = true;
    rival.near_tie[static_cast<std::size_t>(w)] = true;
  }
}

void MapSampler::findNearTies() {
  for (Family& family : families_) family.near_tie.assign(family.gatherer.voxels().size(), false);
  for (std::size_t arm = 0; arm < arms_.size(); ++arm) {
    for (std::size_t other = 0; other < arms_.size(); ++other) {
      if (arm != other) compare(arm, other);
    }
  }
}

std::optional<Error> MapSampler::refine(Family& family, std::uint64_t pass,
                                        const Deadline& deadline) {
  const std::size_t arm = first(family);
  const double range = arms_[arm].upper()[0] - arms_[arm].lower()[0];
  const Joint& joint = model_.joints[static_cast<std::size_t>(model_.arms[arm].joints.front())];
  const std::vector<Pose> moves = roundOf(joint, range);
  RoundFilter filter(joint, arms_[arm].reach(), params_.voxel);
  std::vector<std::uint32_t> wanted(family.near_tie.size(), 0);  // samples that a voxel still needs
  std::size_t missing = 0;
  for (std::size_t v = 0; v < wanted.size(); ++v) {
    const std::uint32_t samples = family.gatherer.voxels()[v].samples;
    if (!family.near_tie[v] || samples >= params_.tie_samples) continue;
    wanted[v] = params_.tie_samples - samples;
    filter.want(family.gatherer.centre(v));
    ++missing;
  }
  for (std::uint64_t ring = 0; ring < kRings && missing > 0; ++ring) {
    if (ring % kBlock == 0) {
      if (auto error = stopped(deadline)) return error;
    }
    // The position drawn for the first joint says where within a step the round begins: each of its
    // positions is uniform over the range then.
    ArmVector q = draw(arm, params_.samples + pass * kRings + ring);
    q[0] = arms_[arm].lower()[0] + (q[0] - arms_[arm].lower()[0]) / kRing;
    const Pose X_AT = arms_[arm].toolPose(q);
    if (!filter.mayHit(X_AT.translation())) continue;
    std::optional<MapSample> begin;  // what of it stays the same all round, once it is needed
    for (std::size_t step = 0; step < moves.size(); ++step) {
      const Eigen::Vector3d p_A = moves[step] * X_AT.translation();
      const std::int32_t voxel = family.gatherer.find(p_A);
      if (voxel < 0 || wanted[static_cast<std::size_t>(voxel)] == 0) continue;
      if (!begin) begin = sampleAt(arm, q);
      MapSample sample{p_A, moves[step].linear() * begin->approach_A, begin->manipulability, q};
      sample.q[0] += range * static_cast<double>(step) / kRing;
      if (touches(arm, sample.q)) continue;
      family.gatherer.add(sample);
      ++family.accepted;
      if (--wanted[static_cast<std::size_t>(voxel)] == 0) --missing;
    }
  }
  return std::nullopt;
}

MapReport MapSampler::report(std::size_t arm) const {
  const Seat& seat = seats_[arm];
  const Family& family = families_[seat.family];
  MapReport report;
  if (seat.member > 0) report.image_of = static_cast<int>(first(family));
  report.why_own = seat.why_own;
  report.accepted = family.accepted;
  for (std::size_t v = 0; v < family.near_tie.size(); ++v) {
    if (!family.near_tie[v]) continue;
    ++report.near_ties;
    if (family.gatherer.voxels()[v].samples < params_.tie_samples) ++report.near_ties_short;
  }
  return report;
}

MapContents MapSampler::contents(std::size_t arm) const {
  const Family& family = families_[seats_[arm].family];
  const auto& mirror = family.members[seats_[arm].member].mirror;
  return mirror ? family.gatherer.contents(*mirror) : family.gatherer.contents();
}

}  // namespace handover::reachability
