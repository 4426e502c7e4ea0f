#include <algorithm>
#include <cmath>
#include <memory>

#include "stacking/builder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/grasp_check.hpp"

namespace stonestack {
namespace {

/// What the search asks the arm: the pick side of each stone is worked out once.
struct Reach {
  Belief belief;
  PlanningScene scene;
  Joints q;
  std::map<int, GraspFinder> finders;
};

}  // namespace

SearchProblem Builder::make_problem(const Belief& belief) const {
  SearchProblem problem;
  problem.shapes = &shapes_;
  problem.stack.stones = belief.stack;
  problem.site = cell_.layout.site;
  std::vector<int> order;
  for (const auto& placed : belief.stack) order.push_back(placed.stone);
  for (const auto& loose : belief.loose) {
    order.push_back(loose.stone);
    if (!given_up_.contains(order)) problem.available.push_back(loose);
    order.pop_back();
  }
  auto reach = std::make_shared<Reach>(
      Reach{belief, make_planning_scene(cell_.layout, robot_, catalogue_, belief), cell_.arm.state().q, {}});
  problem.reachable = [this, reach](int stone, const Pose& T_W_O) {
    auto finder = reach->finders.find(stone);
    if (finder == reach->finders.end()) {
      const auto task = make_task(catalogue_, reach->belief, stone, T_W_O, reach->q);
      GraspFinder made(reach->scene, *task.stone, task.object, task.T_W_O_pick, options_.motion);
      finder = reach->finders.emplace(stone, std::move(made)).first;
    }
    return finder->second.serves(T_W_O);
  };
  return problem;
}

std::optional<Target> Builder::find_target() {
  const SearchProblem problem = make_problem(belief_);
  if (problem.available.empty()) {
    result_.end = RunResult::End::kNoPose;
    result_.ended = "no feasible pose: each stone that is left was tried on this stack";
    return std::nullopt;
  }
  const Stopwatch watch;
  const SearchResult found = search_by_friction(problem, options_.search);
  result_.seconds.search += watch.seconds();
  if (found.best.empty()) {
    result_.end = RunResult::End::kNoPose;
    result_.ended = "no feasible pose: " + found.reason;
    return std::nullopt;
  }
  std::string refusals;
  for (const auto& placement : found.best) {
    std::string refusal;
    if (auto target = plan(placement, &refusal)) return target;
    refusals += concat(refusals.empty() ? "" : "; ", name(placement.stone), ": ", refusal);
  }
  if (!last_.then.empty()) {  // the plan that was followed cannot be carried out: whatever else there is
    last_.then.clear();
    report("the plan cannot be carried out: " + refusals);
    return find_target();
  }
  result_.end = RunResult::End::kNoPlan;
  result_.ended = concat("none of ", found.best.size(), " poses can be reached: ", refusals);
  return std::nullopt;
}

std::vector<double> Builder::frictions() const {
  std::vector<double> list{options_.search.friction};
  while (list.back() < options_.most_friction)
    list.push_back(std::min(options_.most_friction, list.back() + options_.friction_step));
  return list;
}

double Builder::outlook(const SearchProblem& problem, const Placement& found, std::size_t level) const {
  const std::vector<double> assumed = frictions();
  std::vector<PlacedStone> plan{{found.stone, found.T_W_O}};
  plan.insert(plan.end(), found.then.begin(), found.then.end());
  SearchProblem here = problem;
  here.reachable = nullptr;  // it was asked when the plan was made
  SearchOptions search = options_.search;
  double sum = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < assumed.size(); ++k) {
    const auto weight = static_cast<double>(k + 1);  // ours: dry stone has more friction rather than less
    weights += weight;
    search.friction = assumed[k];
    if (k == level) sum += weight * found.expected_height;
    if (k <= level) continue;
    const SearchResult firmer = follow_plan(here, plan, search);
    if (!firmer.best.empty()) sum += weight * firmer.best.front().expected_height;
  }
  return sum / weights;
}

std::vector<PlacedStone> Builder::rest_of_plan() const {
  if (belief_.stack.empty() || belief_.stack.back().stone != last_.stone) return {};
  const Pose moved = belief_.stack.back().T_W_O * last_.T_W_O.inverse();
  std::vector<PlacedStone> rest = last_.then;
  for (PlacedStone& next : rest) next.T_W_O = moved * next.T_W_O;
  return rest;
}

/// A plan that still holds needs no search. Otherwise what holds with little friction first; more is assumed
/// as long as the tower found so far is not expected to stand whole.
SearchResult Builder::search_by_friction(const SearchProblem& problem, const SearchOptions& options) {
  const std::vector<double> assumed = frictions();
  SearchOptions search = options;
  if (const auto plan = rest_of_plan(); !plan.empty()) {
    search.friction = assumed[last_level_];
    SearchResult found = follow_plan(problem, plan, search);
    if (!found.best.empty()) {
      report("the plan still holds");
      return found;
    }
    report("the plan does not hold any more: " + found.reason);
  }
  const auto levels = static_cast<double>(
      std::min(problem.available.size(), static_cast<std::size_t>(options_.search.horizon)));
  SearchResult best;
  double most = 0.0;
  for (std::size_t level = 0; level < assumed.size() && most < options_.sure_success * levels; ++level) {
    search.friction = assumed[level];
    SearchResult found = find_next_pose(problem, search, hooks_.report);
    const double expected = found.best.empty() ? 0.0 : outlook(problem, found.best.front(), level);
    report(concat("friction ", search.friction, ": ",
                  found.best.empty() ? found.reason
                                     : concat(std::round(10 * expected) / 10, " of ", levels,
                                              " stones are expected to stand")));
    if (best.best.empty() || expected > most) {
      most = expected;
      last_level_ = level;
      best = std::move(found);
    }
  }
  if (!best.best.empty() && options.verify && most < options_.least_expected) {
    best.best.clear();
    best.reason = concat("by the best way found only ", std::round(100 * most) / 100,
                         " more stones are expected to stand (least: ", options_.least_expected, ")");
  }
  return best;
}

std::optional<Target> Builder::plan(const Placement& placement, std::string* refusal) {
  throw_if_interrupted();
  const Stopwatch watch;
  Target target{placement, {}, make_planning_scene(cell_.layout, robot_, catalogue_, belief_)};
  const Pose T_W_O_aim = Eigen::Translation3d(-placing_bias()) * placement.T_W_O;
  auto task = make_task(catalogue_, belief_, placement.stone, T_W_O_aim, cell_.arm.state().q);
  if (const auto failed = failed_grasps_.find(placement.stone); failed != failed_grasps_.end())
    task.avoid = failed->second;
  target.plan = plan_pick_and_place(target.scene, task, options_.motion);
  if (target.plan.status != PickAndPlacePlan::Status::kPlanned && !task.avoid.empty()) {
    task.avoid.clear();  // better the grasp that failed once more than none
    target.plan = plan_pick_and_place(target.scene, task, options_.motion);
  }
  result_.seconds.planning += watch.seconds();
  if (target.plan.status == PickAndPlacePlan::Status::kPlanned) return target;
  *refusal = target.plan.reason;
  return std::nullopt;
}

Eigen::Vector3d Builder::placing_bias() const {
  constexpr double kLargest = 0.008;  // m: a stone seen further off has slid
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  if (!options_.correct_aim) return sum;
  int count = 0;
  for (const auto& entry : result_.placements) {
    if (entry.outcome != PlacementRecord::Outcome::kPlaced || !entry.T_W_O_measured) continue;
    const Eigen::Vector3d offset = entry.T_W_O_measured->translation() - entry.planned.T_W_O.translation();
    if (offset.head<2>().norm() > kLargest) continue;
    sum += Eigen::Vector3d(offset.x(), offset.y(), 0.0) +
           aimed_off_[static_cast<std::size_t>(&entry - result_.placements.data())];
    ++count;
  }
  return count == 0 ? sum : Eigen::Vector3d(sum / count);
}

}  // namespace stonestack
