// SPDX-License-Identifier: Apache-2.0
#include "core/collision/continuous_collision_checker.hpp"

#include <stdexcept>

namespace handover {

bool ContinuousCollisionChecker::free(CollisionWorld& world, const PairList& pairs,
                                      RigidGroups& groups, const std::vector<MovingBody>& moving,
                                      const std::vector<int>& moving_index,
                                      const JointMotion& motion, double from, double to,
                                      const Clearance& clearance, BodyContact* hit) {
  const auto indexOf = [&](BodyId body) { return moving_index[body]; };
  rows_ = pairs.rows();
  intervals_.assign(1, {from, to, 0, rows_.size()});
  // Breadth first: what touches is found by few looks spread over the motion.
  for (std::size_t i = 0; i < intervals_.size(); ++i) {
    const Interval it = intervals_[i];
    motion.stretch(it.from, it.to, interval_);
    if (interval_.q_middle.size() != groups.dofs() || !interval_.q_middle.allFinite()) {
      throw std::invalid_argument("one finite position per moving dof");
    }
    groups.place(interval_.q_middle);
    groups.boundTravel(interval_);
    const PairList::Row* rows = rows_.data() + it.first;
    const std::size_t count = it.last - it.first;
    // Only the bodies of the pairs that are left.
    wanted_.assign(moving.size(), false);
    PairList::Row movers{-1, {}, 0};
    const auto wantMovers = [&] {
      pairs.forEachMover(movers, [&](BodyId mover, std::uint64_t) {
        wanted_[static_cast<std::size_t>(indexOf(mover))] = true;
      });
    };
    for (std::size_t r = 0; r < count; ++r) {
      const int other = indexOf(rows[r].other);
      if (other >= 0) wanted_[static_cast<std::size_t>(other)] = true;
      if (rows[r].group != movers.group) {
        wantMovers();
        movers = {rows[r].group, {}, 0};
      }
      movers.movers |= rows[r].movers;
    }
    wantMovers();
    for (std::size_t b = 0; b < moving.size(); ++b) {
      const MovingBody& body = moving[b];
      if (wanted_[b]) world.setPose(body.body, groups.pose(body.group) * body.X_GB);
    }
    undecided_.clear();
    const BodyTravel travel(groups, moving, moving_index);
    if (!world.staysFree(pairs, rows, count, travel, clearance, undecided_, hit)) return false;
    if (undecided_.empty()) continue;
    const std::size_t first = rows_.size();
    rows_.insert(rows_.end(), undecided_.begin(), undecided_.end());
    const double middle = 0.5 * (it.from + it.to);
    intervals_.push_back({it.from, middle, first, rows_.size()});
    intervals_.push_back({middle, it.to, first, rows_.size()});
  }
  return true;
}

}  // namespace handover
