#include "motion/path/rrt_connect.hpp"

#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

namespace ob = ompl::base;
using Space = ob::RealVectorStateSpace;

constexpr double kRrtStep = 0.5;      // scaled rad, how far a tree grows at once
constexpr double kWithin = 0.9;       // of the samples, once a length is given
constexpr double kNearLine = 0.7;     // of the others
constexpr double kArmAnywhere = 0.2;  // of the others
constexpr int kDraws = 20;  // of a sample that lies on no path that is short enough; then any sample does
// How far a joint's turn moves the gripper, against the base's: distances in the planner are about those of
// the gripper.
const Joints kWeight = (Joints() << 1.0, 1.0, 0.7, 0.4, 0.3, 0.2).finished();

Joints joints_of(const ob::State* state) {
  const auto* values = state->as<Space::StateType>()->values;
  return Eigen::Map<const Joints>(values).cwiseQuotient(kWeight);
}
void set_state(const Joints& q, ob::State* state) {
  Eigen::Map<Joints>(state->as<Space::StateType>()->values) = q.cwiseProduct(kWeight);
}

/// Most samples lie about the straight lines from start to the goals, where a path around a small obstacle
/// passes; some have the arm anywhere and the wrist nearly on such a line; the rest is uniform. Once a length
/// is given, most are drawn from all that a path of this length can reach (Gammell et al. 2014).
class RrtSampler : public ob::StateSampler {
 public:
  RrtSampler(const ob::StateSpace* space, const Joints& low, const Joints& high, const Joints& start,
             std::span<const Joints> goals, double longest, Random random)
      : ob::StateSampler(space),
        low_(low),
        high_(high),
        start_(start),
        goals_(goals),
        longest_(longest),
        random_(random) {}

  void sampleUniform(ob::State* state) override {
    if (longest_ > 0.0 && random_.uniform() < kWithin) {
      set_state(draw_within(), state);
      return;
    }
    Joints q = draw();
    for (int k = 1; k < kDraws && !is_promising(q); ++k) q = draw();
    set_state(q, state);
  }
  // RRT-Connect asks for none of these.
  void sampleUniformNear(ob::State* state, const ob::State*, double) override { sampleUniform(state); }
  void sampleGaussian(ob::State* state, const ob::State*, double) override { sampleUniform(state); }

 private:
  [[nodiscard]] bool is_promising(const Joints& q) const {
    if (longest_ <= 0.0) return true;
    const double left = longest_ - (q - start_).norm();
    return left > 0.0 && std::any_of(goals_.begin(), goals_.end(), [&](const Joints& goal) {
             return (goal - q).squaredNorm() < left * left;
           });
  }
  Joints draw() {
    const double which = random_.uniform();
    Joints q;
    if (which < kNearLine + kArmAnywhere) {
      const Joints& goal = goals_[random_.index(goals_.size())];
      q = start_ + random_.uniform() * (goal - start_);
      for (auto& angle : q) angle += random_.normal(0.0, 0.5);
    }
    const Eigen::Index free = which < kNearLine ? 0 : which < kNearLine + kArmAnywhere ? 3 : 6;
    for (Eigen::Index i = 0; i < free; ++i) q[i] = random_.uniform(low_[i], high_[i]);
    return q.cwiseMax(low_).cwiseMin(high_);
  }
  /// Uniform in the ellipsoid whose points a path of the given length from start to some goal can pass.
  Joints draw_within() {
    const Joints& goal = goals_[random_.index(goals_.size())];
    const Joints along = goal - start_;
    const double straight = along.norm();
    if (straight <= 0.0 || straight >= longest_) return draw();
    Joints q;
    for (auto& x : q) x = random_.normal(0.0, 1.0);
    q *= std::pow(random_.uniform(), 1.0 / 6.0) / q.norm();
    q[0] *= 0.5 * longest_;
    q.tail<5>() *= 0.5 * std::sqrt(longest_ * longest_ - straight * straight);
    // The mirror that takes the first axis to the line from start to goal.
    const Joints normal = Joints::Unit(0) - along / straight;
    const double square = normal.squaredNorm();
    if (square > 1e-12) q -= 2.0 / square * normal.dot(q) * normal;
    return (0.5 * (start_ + goal) + q).cwiseMax(low_).cwiseMin(high_);
  }

  Joints low_, high_, start_;
  std::span<const Joints> goals_;
  double longest_;
  Random random_;
};

class MotionCheck : public ob::MotionValidator {
 public:
  MotionCheck(const ob::SpaceInformationPtr& information, const CollisionChecker& checker, double resolution)
      : ob::MotionValidator(information), checker_(checker), resolution_(resolution) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    ++count;
    if (resolution_ == 0.0) return checker_.samples_are_free(joints_of(a), joints_of(b));
    return checker_.motion_is_free(joints_of(a), joints_of(b), resolution_);
  }
  bool checkMotion(const ob::State* a, const ob::State* b,
                   std::pair<ob::State*, double>& last) const override {
    last.second = 0.0;
    return checkMotion(a, b);
  }
  mutable long count = 0;

 private:
  const CollisionChecker& checker_;
  double resolution_;
};

/// Where samples are drawn: half a turn around start and goals, within the limits.
std::pair<Joints, Joints> sampled_box(const RobotModel& robot, const Joints& start,
                                      std::span<const Joints> goals) {
  Joints low = start, high = start;
  for (const auto& goal : goals) {
    low = low.cwiseMin(goal);
    high = high.cwiseMax(goal);
  }
  return {(low.array() - kPi).matrix().cwiseMax(robot.lower),
          (high.array() + kPi).matrix().cwiseMin(robot.upper)};
}

}  // namespace

Tree rrt_connect(const CollisionChecker& checker, const Joints& start, std::span<const Joints> goals,
                 const TreeLimits& limits, Random random) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  const auto [low, high] = sampled_box(checker.robot(), start, goals);
  auto space = std::make_shared<Space>(6);
  ob::RealVectorBounds bounds(6);
  for (Eigen::Index i = 0; i < 6; ++i) {
    bounds.setLow(static_cast<unsigned>(i), low[i] * kWeight[i] - 1e-9);
    bounds.setHigh(static_cast<unsigned>(i), high[i] * kWeight[i] + 1e-9);
  }
  space->setBounds(bounds);
  space->setStateSamplerAllocator([&, &low = low, &high = high](const ob::StateSpace* s) {
    return std::make_shared<RrtSampler>(s, low, high, start, goals, limits.longest, random);
  });
  auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker(
      [&](const ob::State* state) { return !checker.collides(joints_of(state)); });
  auto motions = std::make_shared<MotionCheck>(information, checker, limits.resolution);
  information->setMotionValidator(motions);
  information->setup();

  auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<Space> state(space);
  set_state(start, state.get());
  problem->addStartState(state);
  auto goal_states = std::make_shared<ob::GoalStates>(information);
  for (const auto& goal : goals) {
    set_state(goal, state.get());
    goal_states->addState(state);
  }
  problem->setGoal(goal_states);

  ompl::geometric::RRTConnect planner(information);
  planner.setRange(kRrtStep);
  planner.setProblemDefinition(problem);
  planner.setup();
  // A turn of the planner without a motion check (a sample on a tree) is counted as well, so that it ends.
  long turns = 0;
  planner.solve(ob::PlannerTerminationCondition([&] {
    return interrupt_noted() || motions->count > limits.max_motions || ++turns > 20 * limits.max_motions;
  }));
  throw_if_interrupted();
  Tree tree{{}, motions->count};
  if (!problem->hasExactSolution()) return tree;
  const auto* found = problem->getSolutionPath()->as<ompl::geometric::PathGeometric>();
  JointPath& path = tree.path;
  for (std::size_t i = 0; i < found->getStateCount(); ++i)
    path.push_back(joints_of(found->getState(static_cast<unsigned>(i))));
  // The ends exactly as given, not as scaled and scaled back.
  path.front() = start;
  path.back() = *std::min_element(goals.begin(), goals.end(), [&](const Joints& a, const Joints& b) {
    return (a - path.back()).squaredNorm() < (b - path.back()).squaredNorm();
  });
  return tree;
}

}  // namespace stonestack::motion
