// SPDX-License-Identifier: Apache-2.0
#include "core/planning/schedule.hpp"

#include "core/collision/robot_pair_checker.hpp"
#include "core/planning/timed_motion.hpp"

#include <algorithm>
#include <memory>

namespace handover {
namespace {

// Starts tried, the earliest first: at every eighth of what could be gained; then the gap between
// the first that is free and the one before it is halved twice.
constexpr int kParts = 8;
constexpr int kHalvings = 2;

/// Stages that follow each other without a stop, as one motion.
struct Block {
  std::size_t first = 0, end = 0;  ///< stages
  const Manipulator* mover = nullptr;
  bool carries = false;
  std::vector<DofId> dofs;
  TimedPath path;
  double start = 0;

  double stop() const { return start + path.duration(); }
};

bool shareJoints(const Block& a, const Block& b) {
  if (a.mover->robot != b.mover->robot) return false;
  if (a.mover->sameArm(*b.mover)) return true;
  return std::any_of(a.dofs.begin(), a.dofs.end(), [&](DofId dof) {
    return std::find(b.dofs.begin(), b.dofs.end(), dof) != b.dofs.end();
  });
}

/// The curve with more joints, that stand still at a posture.
TimedPath padded(const TimedPath& path, const Eigen::VectorXd& rest) {
  TimedPath all = path;
  const auto stack = [](Eigen::VectorXd& q, const Eigen::VectorXd& below) {
    Eigen::VectorXd both(q.size() + below.size());
    both << q, below;
    q = std::move(both);
  };
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(rest.size());
  for (std::size_t i = 0; i < all.t.size(); ++i) {
    stack(all.q[i], rest);
    stack(all.qd[i], zero);
    stack(all.qdd[i], zero);
  }
  return all;
}

Block blockFrom(const std::vector<TimedStage>& stages, std::size_t first) {
  const TimedStage& head = stages[first];
  Block block{first,     first + 1, head.stage->mover, carries(head.stage->stage), head.dofs,
              head.path, 0};
  for (; block.end < stages.size() && stages[block.end].goes_on; ++block.end) {
    const TimedPath& next = stages[block.end].path;
    const Eigen::VectorXd& q = block.path.q.back();
    const Eigen::Index more = q.size() - next.q.front().size();
    append(block.path, more > 0 ? padded(next, q.tail(more)) : next);
  }
  return block;
}

class Scheduler {
 public:
  Scheduler(CollisionContext& context, const std::vector<TimedStage>& stages,
            const Deadline& deadline)
      : context_(context), stages_(stages), deadline_(deadline), scheduled_(stages.size()) {
    for (const TimedStage& stage : stages) {
      task_.push_back(stage.stage->stage);
      const Manipulator& arm = *stage.stage->mover;
      const std::size_t holder = stage.stage->stage.holder;
      if (arms_.size() <= holder) arms_.resize(holder + 1);
      arms_[holder] = arm.robot.value() * kMostArms + arm.arm.value();
    }
  }

  std::vector<ScheduledStage> schedule() {
    for (std::size_t first = 0; first < stages_.size() && !deadline_.over();
         first = blocks_.back().end) {
      blocks_.push_back(blockFrom(stages_, first));
      place(blocks_.back());
    }
    return std::move(scheduled_);
  }

 private:
  static constexpr int kMostArms = 1024;

  double progressOf(const Precedence& before) const {
    const TimedStage& stage = stages_[before.stage];
    return before.progress == Progress::kClear ? stage.clear : stage.path.duration();
  }

  /// When everything that has to come before the block has come about.
  double earliest(const Block& block) {
    double start = 0;
    for (const Precedence& before : precedenceOf(task_, block.first, arms_)) {
      const StageProgress edge{static_cast<std::uint32_t>(before.stage), progressOf(before)};
      scheduled_[block.first].after.push_back(edge);
      start = std::max(start, scheduled_[before.stage].start + edge.progress);
    }
    for (std::size_t i = 0; i + 1 < blocks_.size(); ++i) {
      const Block& other = blocks_[i];
      if (shareJoints(other, block)) start = std::max(start, other.stop());
      // What the block was proven against is where the object stands once this one has begun.
      if (other.carries) start = std::max(start, other.start);
    }
    return start;
  }

  /// From when on another block's end is part of what the block was proven against: it ends, or the
  /// next one of its arm begins.
  double until(std::size_t other) const {
    for (std::size_t i = other + 1; i + 1 < blocks_.size(); ++i) {
      if (blocks_[i].mover->sameArm(*blocks_[other].mover)) return blocks_[i].start;
    }
    return blocks_[other].stop();
  }

  StateChecker checkerOf(const Block& block) {
    // Of both, no contact is allowed: neither hand may touch what the other carries.
    return context_.make(stages_[block.first].stage->state, *block.mover, block.dofs, {});
  }

  /// An earlier block that may be under way when the block begins.
  struct Other {
    const Block* block;
    double until;
    std::unique_ptr<RobotPairChecker> checker;
  };

  std::vector<Other> othersAfter(const Block& block, double time) {
    std::vector<Other> others;
    if (block.dofs.empty()) return others;
    StateChecker own = checkerOf(block);
    for (std::size_t i = blocks_.size() - 1; i-- > 0;) {
      const Block& other = blocks_[i];
      if (shareJoints(other, block) || other.dofs.empty() || until(i) <= time) continue;
      StateChecker its = checkerOf(other);
      others.push_back({&other, until(i), std::make_unique<RobotPairChecker>(its, own)});
    }
    return others;
  }

  bool isFree(const Block& block, double start, std::vector<Other>& others) const {
    return std::all_of(others.begin(), others.end(), [&](Other& other) {
      if (other.until <= start || deadline_.over()) return true;
      const double since = start - other.block->start;
      const double window = other.until - start;
      const TimedMotion its(other.block->path, since, since + window);
      const TimedMotion own(block.path, 0, window);
      return other.checker->isMotionFree(BothMotions(its, own));
    });
  }

  void place(Block& block) {
    const double least = earliest(block);
    std::vector<Other> others = othersAfter(block, least);
    double most = least;
    for (const Other& other : others) most = std::max(most, other.until);
    const double gain = most - least;
    int part = 0;
    while (part < kParts && !isFree(block, least + gain * part / kParts, others)) ++part;
    block.start = part == kParts ? most : least + gain * part / kParts;
    double gap = gain / kParts;
    for (int i = 0; part > 0 && i < kHalvings; ++i) {
      gap *= 0.5;
      if (isFree(block, block.start - gap, others)) block.start -= gap;
    }
    setStarts(block, least, others);
  }

  void setStarts(const Block& block, double least, const std::vector<Other>& others) {
    double start = block.start;
    for (std::size_t i = block.first; i < block.end; ++i) {
      scheduled_[i].start = start;
      start += stages_[i].path.duration();
      if (i > block.first) {
        scheduled_[i].after = {{static_cast<std::uint32_t>(i - 1), stages_[i - 1].path.duration()}};
      }
    }
    std::vector<StageProgress>& after = scheduled_[block.first].after;
    if (block.start > least) {
      for (const Other& other : others) waitFor(*other.block, block.start, after);
    }
    std::sort(after.begin(), after.end(),
              [](const StageProgress& a, const StageProgress& b) { return a.stage < b.stage; });
  }

  /// The edge to how far another block has come at a time.
  void waitFor(const Block& other, double time, std::vector<StageProgress>& after) const {
    std::size_t stage = other.first;
    while (stage + 1 < other.end && scheduled_[stage + 1].start <= time) ++stage;
    const double progress =
        std::min(time - scheduled_[stage].start, stages_[stage].path.duration());
    if (progress <= 0) return;
    const auto known = std::find_if(after.begin(), after.end(),
                                    [&](const StageProgress& edge) { return edge.stage == stage; });
    if (known == after.end()) {
      after.push_back({static_cast<std::uint32_t>(stage), progress});
    } else {
      known->progress = std::max(known->progress, progress);
    }
  }

  CollisionContext& context_;
  const std::vector<TimedStage>& stages_;
  const Deadline& deadline_;
  std::vector<TaskStage> task_;
  std::vector<int> arms_;  ///< per holder
  std::vector<Block> blocks_;
  std::vector<ScheduledStage> scheduled_;
};

}  // namespace

std::vector<ScheduledStage> scheduleStages(CollisionContext& context,
                                           const std::vector<TimedStage>& stages,
                                           const Deadline& deadline) {
  return Scheduler(context, stages, deadline).schedule();
}

}  // namespace handover
