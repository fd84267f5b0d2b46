// SPDX-License-Identifier: Apache-2.0
#include "core/motion/ikbirrt.hpp"

#include "core/motion/segment.hpp"

#include <handover/common/random.hpp>

#include <ompl/base/Goal.h>
#include <ompl/base/MotionValidator.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/terminationconditions/IterationTerminationCondition.h>
#include <ompl/datastructures/NearestNeighbors.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace handover {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kLimitSlack = 1e-9;  // [rad]
constexpr std::size_t kMaxDofs = 8;   // of an ArmVector

const double* valuesOf(const ob::State* state) {
  return state->as<ob::RealVectorStateSpace::StateType>()->values;
}

double* valuesOf(ob::State* state) {
  return state->as<ob::RealVectorStateSpace::StateType>()->values;
}

ArmVector toJoints(const ob::State* state, Eigen::Index dofs) {
  return Eigen::Map<const Eigen::VectorXd>(valuesOf(state), dofs);
}

bool withinLimits(const MotionProblem& problem, const ArmVector& q) {
  return q.size() == problem.lower.size() && q.allFinite() &&
         (q - problem.lower).minCoeff() >= -kLimitSlack &&
         (problem.upper - q).minCoeff() >= -kLimitSlack;
}

constexpr double kLeastProgress = 0.2;  // of an extension that is projected, of its length

// Without OMPL's default projections, which draw random matrices that nobody uses here.
class JointSpace : public ob::RealVectorStateSpace {
 public:
  explicit JointSpace(const MotionProblem& problem)
      : RealVectorStateSpace(static_cast<unsigned>(problem.lower.size())), problem_(problem) {
    ob::RealVectorBounds bounds(getDimension());
    for (unsigned j = 0; j < getDimension(); ++j) {
      bounds.setLow(j, problem.lower[j] - kLimitSlack);
      bounds.setHigh(j, problem.upper[j] + kLimitSlack);
    }
    setBounds(bounds);
  }

  void registerProjections() override {}

  /// Where states are projected: what the state on the way becomes by that; `from` if that is
  /// hardly nearer to `to`, at which trees stop.
  void interpolate(const ob::State* from, const ob::State* to, double t,
                   ob::State* state) const override {
    if (!problem_.project) return RealVectorStateSpace::interpolate(from, to, t, state);
    const ArmVector q_from = toJoints(from, problem_.lower.size());
    const ArmVector q_to = toJoints(to, problem_.lower.size());
    ArmVector q = q_from + t * (q_to - q_from);
    const double least = kLeastProgress * (q - q_from).norm();
    const bool nearer = problem_.project(q) && withinLimits(problem_, q) &&
                        (q_to - q).norm() <= (q_to - q_from).norm() - least;
    if (!nearer) q = q_from;
    Eigen::Map<Eigen::VectorXd>(valuesOf(state), q.size()) = q;
  }

 private:
  const MotionProblem& problem_;
};

// Draws from the request's seed alone: OMPL's own generator is seeded by the order in which
// generators are made in the whole process. (The base class has one; it is never asked.)
class SeededSampler : public ob::StateSampler {
 public:
  SeededSampler(const ob::StateSpace* space, const MotionProblem& problem, std::uint64_t seed)
      : StateSampler(space), problem_(problem), random_(seed) {}

  void sampleUniform(ob::State* state) override {
    for (Eigen::Index j = 0; j < problem_.lower.size(); ++j) {
      valuesOf(state)[j] = random_.uniform(problem_.lower[j], problem_.upper[j]);
    }
  }

  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    for (Eigen::Index j = 0; j < problem_.lower.size(); ++j) {
      valuesOf(state)[j] =
          random_.uniform(std::max(problem_.lower[j], valuesOf(near)[j] - distance),
                          std::min(problem_.upper[j], valuesOf(near)[j] + distance));
    }
  }

  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    for (Eigen::Index j = 0; j < problem_.lower.size(); ++j) {
      const double radius = std::sqrt(-2 * std::log(1 - random_.unit()));
      const double q = valuesOf(mean)[j] + deviation * radius * std::cos(2 * M_PI * random_.unit());
      valuesOf(state)[j] = std::clamp(q, problem_.lower[j], problem_.upper[j]);
    }
  }

 private:
  const MotionProblem& problem_;
  SeededRandom random_;
};

class Checker : public ob::StateValidityChecker {
 public:
  Checker(const ob::SpaceInformationPtr& si, const MotionProblem& problem)
      : StateValidityChecker(si), problem_(problem) {}

  bool isValid(const ob::State* state) const override {
    return problem_.valid(toJoints(state, problem_.lower.size()));
  }

 private:
  const MotionProblem& problem_;
};

// OMPL asks only for motions that start at a valid state.
class SegmentChecker : public ob::MotionValidator {
 public:
  SegmentChecker(const ob::SpaceInformationPtr& si, const MotionProblem& problem)
      : MotionValidator(si), problem_(problem) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    const Eigen::Index dofs = problem_.lower.size();
    return restOfSegmentValid(problem_, toJoints(from, dofs), toJoints(to, dofs));
  }

  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(from, to)) return true;
    if (last_valid.first) si_->copyState(last_valid.first, from);
    last_valid.second = 0;
    return false;
  }

 private:
  const MotionProblem& problem_;
};

// OMPL does not plan without a goal; the search asks IkGoals for its own.
class PlaceholderGoal : public ob::Goal {
 public:
  using Goal::Goal;

  bool isSatisfied(const ob::State*) const override { return false; }
};

// The goals as the caller's sampler gives them, counted as they come.
class IkGoals {
 public:
  IkGoals(const MotionProblem& problem, const GoalSampler& sampler)
      : problem_(problem), sampler_(sampler) {}

  /// Draws the next goal; true if it is within limits and valid.
  bool draw(ob::State* state) {
    if (exhausted_) return false;
    ArmVector q;
    if (!sampler_(drawn_, q)) {
      exhausted_ = true;
      return false;
    }
    ++drawn_;
    if (!withinLimits(problem_, q) || !problem_.valid(q)) return false;
    Eigen::Map<Eigen::VectorXd>(valuesOf(state), q.size()) = q;
    ++valid_;
    return true;
  }

  bool exhausted() const { return exhausted_; }

  std::uint32_t drawn() const { return drawn_; }

  std::uint32_t valid() const { return valid_; }

 private:
  const MotionProblem& problem_;
  const GoalSampler& sampler_;
  std::uint32_t drawn_ = 0, valid_ = 0;
  bool exhausted_ = false;
};

// All states in one block, searched from end to end: for the few thousand states of a plan this
// beats a tree, ties go to the older state, and nothing is drawn at random (OMPL's GNAT picks
// pivots so).
template <typename T>
class FlatNearest : public ompl::NearestNeighbors<T> {
 public:
  explicit FlatNearest(std::size_t dofs) : dofs_(dofs) {}

  bool reportsSortedResults() const override { return true; }

  void clear() override {
    items_.clear();
    rows_.clear();
  }

  using ompl::NearestNeighbors<T>::add;

  void add(const T& item) override {
    items_.push_back(item);
    rows_.push_back(rowOf(item));
  }

  bool remove(const T& item) override {
    const auto at = std::find(items_.begin(), items_.end(), item);
    if (at == items_.end()) return false;
    rows_.erase(rows_.begin() + (at - items_.begin()));
    items_.erase(at);
    return true;
  }

  T nearest(const T& item) const override {
    const Row row = rowOf(item);
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double d = squaredDistance(rows_[i], row);
      if (d < least) least = d, best = i;
    }
    return items_.at(best);
  }

  void nearestK(const T& item, std::size_t k, std::vector<T>& found) const override {
    collect(item, std::numeric_limits<double>::infinity(), found);
    found.resize(std::min(k, found.size()));
  }

  void nearestR(const T& item, double radius, std::vector<T>& found) const override {
    collect(item, radius * radius, found);
  }

  std::size_t size() const override { return items_.size(); }

  void list(std::vector<T>& items) const override { items = items_; }

 private:
  using Row = std::array<double, kMaxDofs>;

  Row rowOf(const T& item) const {
    Row row{};
    std::copy_n(valuesOf(static_cast<const ob::State*>(item->state)), dofs_, row.begin());
    return row;
  }

  static double squaredDistance(const Row& a, const Row& b) {
    double even = 0, odd = 0;
    for (std::size_t j = 0; j < kMaxDofs; j += 2) {
      even += (a[j] - b[j]) * (a[j] - b[j]);
      odd += (a[j + 1] - b[j + 1]) * (a[j + 1] - b[j + 1]);
    }
    return even + odd;
  }

  void collect(const T& item, double limit, std::vector<T>& found) const {
    const Row row = rowOf(item);
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double d = squaredDistance(rows_[i], row);
      if (d <= limit) order.emplace_back(d, i);
    }
    std::sort(order.begin(), order.end());
    found.clear();
    for (const auto& [d, i] : order) found.push_back(items_[i]);
  }

  std::size_t dofs_;
  std::vector<T> items_;
  std::vector<Row> rows_;
};

// RRTConnect whose goal tree takes new roots all through the search. OMPL 1.5's own solve() draws a
// goal only when its goal tree has grown to twice the goals drawn: one goal in a pocket that cannot
// grow, and it never draws another.
class IkBiRrt : public og::RRTConnect {
 public:
  IkBiRrt(const ob::SpaceInformationPtr& si, const MotionProblem& problem, IkGoals& goals,
          const IkBiRrtSettings& settings)
      : RRTConnect(si), problem_(problem), goals_(goals), settings_(settings) {
    setName("IKBiRRT");
    setRange(problem.project ? settings.projected_range : settings.range);
    tStart_ = std::make_shared<FlatNearest<Motion*>>(si->getStateDimension());
    tGoal_ = std::make_shared<FlatNearest<Motion*>>(si->getStateDimension());
  }

  ob::PlannerStatus solve(const ob::PlannerTerminationCondition& over) override {
    checkValidity();
    while (const ob::State* state = pis_.nextStart()) addRoot(*tStart_, state);
    if (tStart_->size() == 0) return ob::PlannerStatus::INVALID_START;
    sampler_ = si_->allocStateSampler();
    // States for the two hands of growTree(); freed whatever the callbacks throw.
    Scratch target(si_), step(si_), goal(si_);
    if (tryDirect(goal.motion, over)) return ob::PlannerStatus::EXACT_SOLUTION;
    if (tGoal_->size() == 0) {
      return goals_.exhausted() ? ob::PlannerStatus::INVALID_GOAL : ob::PlannerStatus::TIMEOUT;
    }
    seed(*tStart_, settings_.from_start, goal.motion.state);
    seed(*tGoal_, settings_.from_goal, goal.motion.state);
    bool from_start = true;
    for (std::uint32_t i = 1; !over; ++i, from_start = !from_start) {
      if (i % settings_.goal_period == 0 && goals_.draw(goal.motion.state))
        addGoal(goal.motion.state);
      if (extend(from_start, target.motion, step.motion.state)) {
        return ob::PlannerStatus::EXACT_SOLUTION;
      }
    }
    return ob::PlannerStatus::TIMEOUT;
  }

  std::uint32_t reachedGoal() const { return reached_goal_; }

  std::size_t states() const { return tStart_->size() + tGoal_->size(); }

 private:
  using Tree = ompl::NearestNeighbors<Motion*>;

  struct Scratch {
    explicit Scratch(const ob::SpaceInformationPtr& info) : si(info), motion(info) {}

    ~Scratch() { si->freeState(motion.state); }

    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    ob::SpaceInformationPtr si;
    Motion motion;
  };

  Motion* addRoot(Tree& tree, const ob::State* state) {
    auto* root = new Motion(si_);  // owned by the tree, as RRTConnect::freeMemory() expects
    si_->copyState(root->state, state);
    root->root = root->state;
    tree.add(root);
    return root;
  }

  Motion* addGoal(const ob::State* state) {
    Motion* root = addRoot(*tGoal_, state);
    goal_roots_.emplace_back(root->state, goals_.drawn() - 1);
    return root;
  }

  static Motion* rootOf(const Tree& tree) {
    std::vector<Motion*> states;
    tree.list(states);
    return states.front();
  }

  // Grows a tree from its first root along a way, as far as that is free.
  void seed(Tree& tree, const std::vector<ArmVector>& way, ob::State* scratch) {
    Motion* last = rootOf(tree);
    ArmVector at = toJoints(last->state, problem_.lower.size());
    for (const ArmVector& q : way) {
      if (!withinLimits(problem_, q)) return;
      const ArmVector from = at;
      const int pieces = static_cast<int>(std::ceil(2 * (q - from).norm() / settings_.range));
      for (int piece = 1; piece <= pieces; ++piece) {  // none if it is there already
        const ArmVector to = from + static_cast<double>(piece) / pieces * (q - from);
        if (!segmentValid(problem_, at, to)) return;
        Eigen::Map<Eigen::VectorXd>(valuesOf(scratch), q.size()) = to;
        Motion* added = addRoot(tree, scratch);
        added->parent = last;
        added->root = last->root;
        last = added;
        at = to;
      }
    }
  }

  // Draws goals until one is valid, then up to `direct_goals` of them, each tried by one straight
  // segment.
  bool tryDirect(Motion& goal, const ob::PlannerTerminationCondition& over) {
    std::vector<Motion*> starts;
    tStart_->list(starts);
    const std::uint32_t most_draws = 4 * settings_.direct_goals;
    const auto more = [&] {
      if (goals_.exhausted()) return false;
      if (tGoal_->size() == 0) return true;
      return tGoal_->size() < settings_.direct_goals && goals_.drawn() < most_draws;
    };
    while (more() && !over) {
      if (!goals_.draw(goal.state)) continue;
      Motion* root = addGoal(goal.state);
      if (settings_.direct_goals > 0 && si_->checkMotion(starts.front()->state, root->state)) {
        finish(starts.front(), root);
        return true;
      }
    }
    return false;
  }

  // One step of RRTConnect: one tree towards a sample, the other towards what that reached.
  bool extend(bool from_start, Motion& target, ob::State* step) {
    TreeGrowingInfo grow{step, nullptr, from_start};
    // Projected trees first go to meet each other: straight segments, which were tried before, are
    // not the way that they take.
    if (problem_.project && !met_first_) {
      si_->copyState(target.state, rootOf(from_start ? *tGoal_ : *tStart_)->state);
      met_first_ = true;
    } else {
      sampleFor(from_start, target.state);
    }
    const GrowState first = growTree(from_start ? tStart_ : tGoal_, grow, &target);
    if (first == TRAPPED) return false;
    Motion* added = grow.xmotion;
    if (first == ADVANCED) si_->copyState(target.state, added->state);
    grow.start = !from_start;
    GrowState second = ADVANCED;
    while (second == ADVANCED) second = growTree(from_start ? tGoal_ : tStart_, grow, &target);
    if (second != REACHED) return false;
    Motion* met = grow.xmotion;
    Motion* start_side = from_start ? added : met;
    Motion* goal_side = from_start ? met : added;
    // Both are the same state: leave one out, but never a root.
    if (start_side->parent) {
      start_side = start_side->parent;
    } else {
      goal_side = goal_side->parent;
    }
    finish(start_side, goal_side);
    return true;
  }

  // A tree that hardly grows is in a pocket, which far samples leave through no straight segment:
  // every second one is then drawn near one of its states.
  void sampleFor(bool from_start, ob::State* sample) {
    const Tree& tree = from_start ? *tStart_ : *tGoal_;
    std::uint32_t& asked = cramped_[from_start ? 0 : 1];
    if (tree.size() > settings_.cramped_states || ++asked % 2 != 0) {
      sampler_->sampleUniform(sample);
      return;
    }
    std::vector<Motion*> states;
    tree.list(states);
    const ob::State* near = states[asked / 2 % states.size()]->state;
    sampler_->sampleUniformNear(sample, near, settings_.cramped_step);
  }

  void finish(Motion* start_side, Motion* goal_side) {
    auto path = std::make_shared<og::PathGeometric>(si_);
    std::vector<const Motion*> forward;
    for (const Motion* m = start_side; m; m = m->parent) forward.push_back(m);
    for (auto m = forward.rbegin(); m != forward.rend(); ++m) path->append((*m)->state);
    for (const Motion* m = goal_side; m; m = m->parent) path->append(m->state);
    for (const auto& [root, index] : goal_roots_) {
      if (root == goal_side->root) reached_goal_ = index;
    }
    pdef_->addSolutionPath(path, false, 0.0, getName());
  }

  const MotionProblem& problem_;
  IkGoals& goals_;
  const IkBiRrtSettings settings_;
  std::vector<std::pair<const ob::State*, std::uint32_t>> goal_roots_;
  std::array<std::uint32_t, 2> cramped_{};  ///< samples while the start, the goal tree was small
  std::uint32_t reached_goal_ = 0;
  bool met_first_ = false;
};

// OMPL prints to the console unless told otherwise; a process-wide switch of OMPL's own.
void silenceOmpl() {
  static std::once_flag once;
  std::call_once(once, [] { ompl::msg::noOutputHandler(); });
}

std::string faultOf(const MotionProblem& problem, const ArmVector& start,
                    const IkBiRrtSettings& settings) {
  if (problem.lower.size() == 0) return "limits: none";
  if (problem.upper.size() != problem.lower.size())
    return "limits: sizes of lower and upper differ";
  if (!problem.lower.allFinite() || !problem.upper.allFinite()) return "limits: not finite";
  if ((problem.upper - problem.lower).minCoeff() < 0) return "limits: lower is above upper";
  if (!problem.valid) return "valid: no function";
  if (!(problem.resolution > 0)) return "resolution: not above 0";
  if (!(settings.range > 0) || !std::isfinite(settings.range))
    return "range: not above 0 and finite";
  if (settings.goal_period == 0) return "goal_period: 0";
  if (start.size() != problem.lower.size()) return "start: size differs from the limits'";
  if (!start.allFinite()) return "start: not finite";
  if (!withinLimits(problem, start)) return "start: outside the limits";
  return "";
}

}  // namespace

Result<JointPath> planIkBiRrt(const MotionProblem& problem, const ArmVector& start,
                              const GoalSampler& goals, const IkBiRrtSettings& settings,
                              const Deadline& deadline, std::uint32_t* goal) {
  if (const std::string fault = faultOf(problem, start, settings); !fault.empty()) {
    return {ErrorCode::kInvalidInput, fault};
  }
  if (!goals) return {ErrorCode::kInvalidInput, "goals: no function"};
  silenceOmpl();
  const auto stopped = [&]() -> Error {
    return deadline.state() == Deadline::State::kCancelled
               ? Error{ErrorCode::kCancelled, "cancelled while planning a path"}
               : Error{ErrorCode::kDeadline, "deadline passed while planning a path"};
  };
  if (deadline.over()) return stopped();
  if (!problem.valid(start)) return {ErrorCode::kInCollision, "the start configuration is invalid"};

  const auto space = std::make_shared<JointSpace>(problem);
  space->setStateSamplerAllocator([&](const ob::StateSpace* of) {
    return std::make_shared<SeededSampler>(of, problem, settings.seed);
  });
  const auto si = std::make_shared<ob::SpaceInformation>(space);
  si->setStateValidityChecker(std::make_shared<Checker>(si, problem));
  si->setMotionValidator(std::make_shared<SegmentChecker>(si, problem));
  si->setup();

  const auto definition = std::make_shared<ob::ProblemDefinition>(si);
  const Eigen::Index dofs = start.size();
  ob::ScopedState<> first(space);
  Eigen::Map<Eigen::VectorXd>(valuesOf(first.get()), dofs) = start;
  definition->addStartState(first);
  definition->setGoal(std::make_shared<PlaceholderGoal>(si));
  IkGoals ik_goals(problem, goals);

  IkBiRrt planner(si, problem, ik_goals, settings);
  planner.setProblemDefinition(definition);
  planner.setup();
  ob::IterationTerminationCondition iterations(settings.max_iterations);
  const ob::PlannerTerminationCondition over([&] { return deadline.over() || iterations.eval(); });
  const ob::PlannerStatus status = planner.solve(over);

  if (static_cast<ob::PlannerStatus::StatusType>(status) != ob::PlannerStatus::EXACT_SOLUTION) {
    if (deadline.over()) return stopped();
    return {ErrorCode::kNoPath, "no path with " + std::to_string(planner.states()) +
                                    " states and " + std::to_string(ik_goals.valid()) +
                                    " valid of " + std::to_string(ik_goals.drawn()) +
                                    " goals drawn"};
  }
  auto* found = definition->getSolutionPath()->as<og::PathGeometric>();
  JointPath path;
  path.waypoints.reserve(found->getStateCount());
  for (const ob::State* state : found->getStates()) path.waypoints.push_back(toJoints(state, dofs));
  if (goal) *goal = planner.reachedGoal();
  return path;
}

}  // namespace handover
