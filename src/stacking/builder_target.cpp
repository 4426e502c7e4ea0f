#include <algorithm>
#include <cmath>
#include <memory>

#include "search/parallel.hpp"
#include "stacking/builder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/grasp_check.hpp"

namespace stonestack {
namespace {

constexpr std::size_t kMostRefused = 12;  // poses without a motion, after which no others are looked for
constexpr double kSamePlace = 0.012;      // m, of the centre of mass: nearer is what was tried before
constexpr double kSameTurn = 0.26;        // rad: the same

/// What the search asks the arm: the pick side of each stone is worked out once.
struct Reach {
  Belief belief;
  PlanningScene scene;
  Joints q;
  std::map<int, GraspFinder> finders;
};

/// Of an assumed friction in the outlook; ours: dry stone has more friction rather than less.
double weight_of(std::size_t level) {
  return static_cast<double>(level + 1);
}

std::vector<PlacedStone> plan_of(const Placement& first) {
  std::vector<PlacedStone> plan{{first.stone, first.T_W_O}};
  plan.insert(plan.end(), first.then.begin(), first.then.end());
  return plan;
}

}  // namespace

SearchProblem Builder::make_problem(const Belief& belief) const {
  SearchProblem problem;
  problem.shapes = &shapes_;
  problem.stack.stones = belief.stack;
  problem.site = cell_.layout.site;
  for (const PlacedStone& loose : belief.loose)
    if (can_carry(loose.stone)) problem.available.push_back(loose);
  auto reach = std::make_shared<Reach>(
      Reach{belief, make_planning_scene(cell_.layout, robot_, catalogue_, belief), cell_.arm.state().q, {}});
  problem.reachable = [this, reach](int stone, const Pose& T_W_O, const Stack& below) {
    if (was_given_up(stone, T_W_O)) return false;
    auto finder = reach->finders.find(stone);
    if (finder == reach->finders.end()) {
      const auto task = make_task(catalogue_, reach->belief, stone, T_W_O, reach->q);
      GraspFinder made(reach->scene, *task.stone, task.object, task.T_W_O_pick, options_.motion);
      finder = reach->finders.emplace(stone, std::move(made)).first;
    }
    std::vector<SceneObject> planned;
    for (std::size_t k = reach->belief.stack.size(); k < below.stones.size(); ++k) {
      const Stone& lower = catalogue_.stones[static_cast<std::size_t>(below.stones[k].stone)];
      planned.push_back({lower.name, lower.pieces, below.stones[k].T_W_O});
    }
    const auto failed = failed_grasps_.find(stone);
    const bool any = failed == failed_grasps_.end();
    const GraspCheck check = finder->second.check(T_W_O, any ? 1 : 0, planned);
    if (any) return !check.usable.empty();
    return std::any_of(check.usable.begin(), check.usable.end(), [&](int k) {
      const Grasp& grasp = finder->second.set().grasps[static_cast<std::size_t>(k)];
      return !is_near_grasp(failed->second, grasp.T_O_T);
    });
  };
  return problem;
}

bool Builder::can_carry(int stone) const {
  return catalogue_.stones[static_cast<std::size_t>(stone)].mass.mass <= make_robotiq_3f().payload;
}

std::string Builder::too_heavy() const {
  std::string list;
  for (const PlacedStone& loose : belief_.loose)
    if (!can_carry(loose.stone))
      list += concat(list.empty() ? "" : ", ", name(loose.stone), " (",
                     catalogue_.stones[static_cast<std::size_t>(loose.stone)].mass.mass, " kg)");
  return list;
}

bool Builder::dare_failed_grasps() {
  if (failed_grasps_.empty()) return false;
  report("no other way is left than grasps that failed before: they are tried again");
  failed_grasps_.clear();
  return true;
}

bool Builder::was_given_up(int stone, const Pose& T_W_O) const {
  const auto same = [&](const PlacedStone& top) {
    if (top.stone != stone) return false;
    const Eigen::Vector3d& p_O_M = shapes_[static_cast<std::size_t>(stone)]->mass.p_O_M;
    return (top.T_W_O * p_O_M - T_W_O * p_O_M).norm() < kSamePlace &&
           difference(top.T_W_O, T_W_O).angle < kSameTurn;
  };
  return std::any_of(given_up_.begin(), given_up_.end(), same) ||
         std::any_of(refused_.begin(), refused_.end(), same);
}

std::optional<Target> Builder::find_target() {
  const SearchProblem problem = make_problem(belief_);
  if (problem.available.empty()) {
    result_.end = RunResult::End::kNoPose;
    result_.ended = concat("no feasible pose: what is left is heavier than the hand carries (",
                           make_robotiq_3f().payload, " kg): ", too_heavy());
    return std::nullopt;
  }
  const Stopwatch watch;
  const SearchResult found = search_by_friction(problem, options_.search.largest_tilt);
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
  if (!rest_of_plan().empty()) {  // the plan that was followed cannot be carried out: whatever else there is
    last_ = {};
    report("the plan cannot be carried out: " + refusals);
    return find_target();
  }
  if (refused_.size() < kMostRefused) {  // other poses then, of other stones perhaps
    for (const auto& placement : found.best) refused_.push_back({placement.stone, placement.T_W_O});
    report(concat("none of ", found.best.size(), " poses can be reached, looking for others: ", refusals));
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

SearchOptions Builder::search_at(std::size_t level) const {
  const std::vector<double> assumed = frictions();
  SearchOptions search = options_.search;
  search.friction = assumed[level];
  if (level + 1 < assumed.size()) search.rounds = std::min(search.rounds, options_.first_rounds);
  return search;
}

double Builder::outlook(const SearchProblem& problem, const Placement& found, std::size_t level) const {
  const std::vector<double> assumed = frictions();
  const std::vector<PlacedStone> plan = plan_of(found);
  SearchProblem here = problem;
  here.reachable = nullptr;  // it was asked when the plan was made
  SearchOptions search = options_.search;
  search.threads = 1;
  std::vector<double> expected(assumed.size(), found.expected_height);
  run_tasks(options_.search.threads, assumed.size(), [&](std::size_t k) {
    if (k == level) return;
    SearchOptions other = search;
    other.friction = assumed[k];
    expected[k] = follow_plan(here, plan, other).held;
  });
  double sum = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < assumed.size(); ++k) {
    weights += weight_of(k);
    sum += weight_of(k) * expected[k];
  }
  return sum / weights;
}

std::vector<PlacedStone> Builder::rest_of_plan() const {
  const auto is_last = [&](const PlacedStone& stone) { return stone.stone == last_.stone; };
  if (belief_.stack.size() == last_below_ && std::any_of(belief_.loose.begin(), belief_.loose.end(), is_last))
    return plan_of(last_);  // it was not picked: another grasp may do
  if (belief_.stack.empty() || !is_last(belief_.stack.back())) return {};
  const Pose moved = belief_.stack.back().T_W_O * last_.T_W_O.inverse();
  std::vector<PlacedStone> rest = last_.then;
  for (PlacedStone& next : rest) next.T_W_O = moved * next.T_W_O;
  return rest;
}

std::optional<SearchResult> Builder::rest_that_holds(const SearchProblem& problem, double largest_tilt,
                                                     double levels) {
  const std::vector<double> assumed = frictions();
  SearchOptions search = options_.search;
  search.largest_tilt = largest_tilt;
  const std::vector<PlacedStone> plan = rest_of_plan();
  for (std::size_t level = last_level_; !plan.empty() && level < assumed.size(); ++level) {
    search.friction = assumed[level];
    SearchResult found = follow_plan(problem, plan, search);
    if (found.best.empty()) {
      report(concat("friction ", search.friction, ": the plan does not hold any more: ", found.reason));
      continue;
    }
    if (level > last_level_ && outlook(problem, found.best.front(), level) < options_.sure_success * levels)
      break;
    report("the plan still holds");
    last_level_ = level;
    return found;
  }
  return std::nullopt;
}

/// A plan that still holds needs no search. Otherwise what holds with little friction first; more is assumed
/// as long as the tower found so far is not expected to stand whole: first to go on from where it ends, then
/// for other ways.
SearchResult Builder::search_by_friction(const SearchProblem& problem, double largest_tilt) {
  const std::size_t count = frictions().size();
  const auto levels = static_cast<double>(
      std::min(problem.available.size(), static_cast<std::size_t>(options_.search.horizon)));
  if (auto found = rest_that_holds(problem, largest_tilt, levels)) return *found;
  SearchResult best;
  double most = 0.0;
  const auto sure = [&] { return most >= options_.sure_success * levels; };
  const auto search = [&](std::size_t level, bool way_up_only) {
    SearchProblem here = problem;
    here.way_up_only = way_up_only;
    if (!best.best.empty()) here.way_up = plan_of(best.best.front());
    if (static_cast<double>(here.way_up.size()) >= levels) here.way_up.clear();  // it is whole, but doubtful
    if (way_up_only && here.way_up.empty()) return;
    SearchOptions options = search_at(level);
    options.largest_tilt = largest_tilt;
    SearchResult found = find_next_pose(here, options, hooks_.report);
    if (way_up_only && (found.best.empty() || plan_of(found.best.front()).size() <= here.way_up.size()))
      return;
    const double expected = found.best.empty() ? 0.0 : outlook(problem, found.best.front(), level);
    report(concat("friction ", options.friction, ": ",
                  found.best.empty() ? found.reason
                                     : concat(std::round(10 * expected) / 10, " of ", levels,
                                              " stones are expected to stand")));
    if (!best.best.empty() && expected <= most) return;
    most = expected;
    last_level_ = level;
    best = std::move(found);
  };
  for (std::size_t level = 0; level < count && !sure(); ++level) {
    const double before = most;
    search(level, false);
    for (std::size_t higher = level + 1; higher < count && most > before && !sure(); ++higher)
      search(higher, true);
  }
  if (!best.best.empty() && options_.search.verify && most < options_.least_expected) {
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
