// SPDX-License-Identifier: Apache-2.0
#include "core/motion/lazy_roadmap.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace handover {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// A dense graph over the configurations; edges cost kNever once they are known to be no good.
class ViaGraph {
 public:
  ViaGraph(const MotionProblem& problem, std::vector<ArmVector> nodes, const SegmentCost& cost)
      : problem_(problem),
        nodes_(std::move(nodes)),
        size_(nodes_.size()),
        costs_(size_ * size_, kNever),
        known_(size_ * size_, false),
        node_known_(size_, false),
        failed_(size_, 0),
        before_(size_, kFrom) {
    node_known_[kFrom] = node_known_[kTo] = true;
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        costs_[i * size_ + j] = costs_[j * size_ + i] = cost(nodes_[i], nodes_[j]);
      }
    }
  }

  std::optional<JointPath> search(const LazyRoadmapSettings& settings, const Deadline& deadline) {
    if (!settings.straight) drop(kFrom, kTo);
    measureToGo();
    while (checks_ < settings.most_checks && !deadline.over()) {
      if (!shortest(settings.most)) return std::nullopt;
      if (!good()) continue;
      JointPath path;
      for (const std::size_t node : way_) path.waypoints.push_back(nodes_[node]);
      return path;
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kFrom = 0, kTo = 1;

  /// A*; the way goes to way_. False if there is none cheaper than `most`.
  bool shortest(double most) {
    distance_.assign(size_, kNever);
    done_.assign(size_, false);
    distance_[kFrom] = 0;
    while (true) {
      std::size_t next = size_;
      double least = kNever;
      for (std::size_t i = 0; i < size_; ++i) {
        const double whole = distance_[i] + to_go_[i];
        if (!done_[i] && whole < least) {
          least = whole;
          next = i;
        }
      }
      if (next == size_ || least > most) return false;
      if (next == kTo) break;
      done_[next] = true;
      expand(next);
    }
    way_.assign(1, kTo);
    while (way_.back() != kFrom) way_.push_back(before_[way_.back()]);
    std::reverse(way_.begin(), way_.end());
    return true;
  }

  void expand(std::size_t node) {
    for (std::size_t i = 0; i < size_; ++i) {
      const double by = distance_[node] + costs_[node * size_ + i];
      if (by >= distance_[i]) continue;
      distance_[i] = by;
      before_[i] = node;
    }
  }

  /// What is left to go from every node while no edge has been dropped: never too much later on.
  void measureToGo() {
    distance_.assign(size_, kNever);
    done_.assign(size_, false);
    distance_[kTo] = 0;
    for (std::size_t n = 0; n < size_; ++n) {
      std::size_t next = size_;
      for (std::size_t i = 0; i < size_; ++i) {
        if (!done_[i] && (next == size_ || distance_[i] < distance_[next])) next = i;
      }
      done_[next] = true;
      expand(next);
    }
    to_go_ = distance_;
  }

  /// Looks at what is not known of the way, the cheap things first.
  bool good() {
    for (const std::size_t node : way_) {
      if (node_known_[node]) continue;
      if (!problem_.valid(nodes_[node])) {
        for (std::size_t i = 0; i < size_; ++i) drop(i, node);
        return false;
      }
      node_known_[node] = true;
    }
    // What fails is found sooner than what is free: the segment first that is likelier to fail, by
    // those that did at its ends.
    order_.clear();
    for (std::size_t i = 1; i < way_.size(); ++i) {
      const std::size_t a = way_[i - 1], b = way_[i];
      if (!known_[a * size_ + b]) order_.emplace_back(a, b);
    }
    std::stable_sort(order_.begin(), order_.end(), [&](const auto& x, const auto& y) {
      return failed_[x.first] + failed_[x.second] > failed_[y.first] + failed_[y.second];
    });
    for (const auto& [a, b] : order_) {
      ++checks_;
      if (!segmentValid(problem_, nodes_[a], nodes_[b])) {
        drop(a, b);
        ++failed_[a];
        ++failed_[b];
        return false;
      }
      known_[a * size_ + b] = known_[b * size_ + a] = true;
    }
    for (std::size_t i = 1; i + 1 < way_.size(); ++i) {
      if (!cornerValid(problem_, nodes_[way_[i - 1]], nodes_[way_[i]], nodes_[way_[i + 1]])) {
        drop(way_[i - 1], way_[i]);
        return false;
      }
    }
    return true;
  }

  void drop(std::size_t a, std::size_t b) {
    costs_[a * size_ + b] = costs_[b * size_ + a] = kNever;
  }

  const MotionProblem& problem_;
  const std::vector<ArmVector> nodes_;
  const std::size_t size_;
  std::vector<double> costs_;
  std::vector<bool> known_;  ///< by pair: the segment is valid
  std::vector<bool> node_known_;
  std::vector<std::uint32_t> failed_;  ///< by node: segments found not valid
  std::vector<double> to_go_;
  std::vector<double> distance_;  // scratch, as the next two
  std::vector<bool> done_;
  std::vector<std::size_t> before_;
  std::vector<std::size_t> way_;
  std::vector<std::pair<std::size_t, std::size_t>> order_;  // scratch
  std::uint32_t checks_ = 0;
};

}  // namespace

std::optional<JointPath> lazyShortestPath(const MotionProblem& problem, const ArmVector& from,
                                          const ArmVector& to, std::vector<ArmVector> vias,
                                          const SegmentCost& cost,
                                          const LazyRoadmapSettings& settings,
                                          const Deadline& deadline) {
  std::vector<ArmVector> nodes{from, to};
  nodes.insert(nodes.end(), std::make_move_iterator(vias.begin()),
               std::make_move_iterator(vias.end()));
  return ViaGraph(problem, std::move(nodes), cost).search(settings, deadline);
}

}  // namespace handover
