#include <algorithm>
#include <array>
#include <cmath>

#include "search/parallel.hpp"
#include "search/search_context.hpp"
#include "stacking/builder.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr std::size_t kInOneGoFirst = 3;  // frictions at which nothing is turned over: that takes 25 s each
constexpr std::size_t kMostRefused = 12;  // poses without a motion, after which no others are looked for

std::vector<PlacedStone> plan_of(const Placement& first) {
  std::vector<PlacedStone> plan{{first.stone, first.T_W_O}};
  plan.insert(plan.end(), first.then.begin(), first.then.end());
  return plan;
}

/// The placements whose plans reach highest, then the others: one that leads nowhere does not go before one
/// for which a stone must be turned over.
std::array<std::vector<Placement>, 2> by_plan_length(const std::vector<Placement>& found) {
  std::size_t longest = 0;
  for (const Placement& placement : found) longest = std::max(longest, placement.then.size());
  std::array<std::vector<Placement>, 2> parts;
  for (const Placement& placement : found)
    parts[placement.then.size() < longest ? 1 : 0].push_back(placement);
  return parts;
}

}  // namespace

std::optional<Target> Builder::find_target() {
  const Stopwatch watch;
  if (const std::string stones = not_held(); stones != said_not_held_) {
    said_not_held_ = stones;
    if (!stones.empty()) report("no grasp holds a stone as it lies: " + stones);
  }
  if (make_problem(belief_, Ways::kInOneGo).available.empty()) {
    result_.end = RunResult::End::kNoPose;
    result_.ended = "no feasible pose: the hand cannot pick up what is left: " + not_held();
    return std::nullopt;
  }
  const SearchResult found = search();
  result_.seconds.search += watch.seconds();
  if (found.best.empty()) {
    result_.end = RunResult::End::kNoPose;
    result_.ended = "no feasible pose: " + found.reason;
    return std::nullopt;
  }
  std::string refusals;
  for (const auto& alike : by_plan_length(found.best)) {
    for (const auto& placement : alike) {
      std::string refusal;
      if (auto target = plan(placement, &refusal)) return target;
      refusals += concat(refusals.empty() ? "" : "; ", name(placement.stone), ": ", refusal);
    }
    if (last_ways_ == Ways::kTurningToo && turn_over(alike)) return find_target();
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

std::vector<double> Builder::assumed_frictions(const BuildOptions& options) {
  std::vector<double> list{options.search.friction};
  while (list.back() < options.most_friction)
    list.push_back(std::min(options.most_friction, list.back() + options.friction_step));
  return list;
}

const std::vector<bool>& Builder::possible() const {
  if (!possible_.empty()) return possible_;
  for (const double friction : friction_.frictions()) {
    SearchOptions search = options_.search;
    search.friction = friction;
    std::string reason;
    possible_.push_back(standing_stack(shapes_, Stack{belief_.stack}, search, &reason).has_value());
  }
  if (std::none_of(possible_.begin(), possible_.end(), [](bool yes) { return yes; }))
    possible_.assign(possible_.size(), true);
  return possible_;
}

std::size_t Builder::first_level() const {
  const std::vector<bool>& levels = possible();
  if (levels[0] && friction_.least_is_likeliest()) return 0;
  for (std::size_t level = 1; level < levels.size(); ++level)
    if (levels[level]) return level;
  return 0;
}

SearchOptions Builder::search_at(std::size_t level, Ways ways) const {
  const std::vector<double>& assumed = friction_.frictions();
  SearchOptions search = options_.search;
  search.friction = assumed[level];
  if (ways == Ways::kTurningToo) search.largest_tilt = M_PI;
  if (level + 1 < assumed.size()) search.rounds = std::min(search.rounds, options_.first_rounds);
  return search;
}

std::vector<double> Builder::expected_by_friction(const SearchProblem& problem,
                                                  const std::vector<PlacedStone>& plan,
                                                  const std::vector<bool>& asked) const {
  const std::vector<double>& assumed = friction_.frictions();
  SearchProblem here = problem;
  here.reachable = nullptr;  // it was asked when the plan was made
  SearchOptions search = options_.search;
  search.threads = 1;
  std::vector<double> expected(assumed.size(), 0.0);
  run_tasks(options_.search.threads, assumed.size(), [&](std::size_t k) {
    if (!asked[k]) return;
    SearchOptions other = search;
    other.friction = assumed[k];
    expected[k] = expected_height(here, plan, other);
  });
  return expected;
}

double Builder::outlook(const SearchProblem& problem, const Placement& found, std::size_t level) const {
  const std::vector<bool>& levels = possible();
  std::vector<bool> asked = levels;
  asked[level] = false;
  std::vector<double> expected = expected_by_friction(problem, plan_of(found), asked);
  expected[level] = found.expected_height;
  return weighed(expected);
}

double Builder::weighed(const std::vector<double>& expected) const {
  const std::vector<bool>& levels = possible();
  double sum = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    if (!levels[k]) continue;
    weights += friction_.weight(k);
    sum += friction_.weight(k) * expected[k];
  }
  return sum / weights;
}

void Builder::learn_from_fall(const std::vector<PlacedStone>& below, const Placement& fallen) {
  const Stopwatch watch;
  SearchProblem problem;
  problem.shapes = &shapes_;
  problem.stack.stones = below;
  problem.site = cell_.layout.site;
  const PlacedStone stone{fallen.stone, fallen.T_W_O};
  problem.available = {stone};
  const std::vector<double>& assumed = friction_.frictions();
  friction_.fell(expected_by_friction(problem, {stone}, std::vector<bool>(assumed.size(), true)));
  result_.seconds.search += watch.seconds();
  std::string text;
  for (std::size_t k = 0; k < assumed.size(); ++k)
    text += concat(k == 0 ? "" : ", ", assumed[k], ": ", std::lround(100 * friction_.weight(k)), " %");
  report("how likely each friction is after that fall: " + text);
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

std::optional<SearchResult> Builder::rest_that_holds(const SearchProblem& problem, Ways ways, double levels) {
  const std::size_t count = friction_.frictions().size();
  const std::vector<PlacedStone> plan = rest_of_plan();
  for (std::size_t level = last_level_; !plan.empty() && level < count; ++level) {
    SearchOptions search = search_at(level, ways);
    SearchResult found = follow_plan(problem, plan, search);
    if (found.best.empty()) {
      report(concat("friction ", search.friction, ": the plan does not hold any more: ", found.reason));
      if (found.unreachable > 0) break;  // by no friction will it be
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

/// A plan that still holds needs no search. Otherwise what holds with little friction first, but not the
/// least, with which towers of four are rarely found (it counts in the outlook); more is assumed as long as
/// the tower found so far is not expected to stand whole: first to go on from where it ends, then for other
/// ways. From the third friction on, or the last, stones may be turned over on the way.
SearchResult Builder::search_by_friction() {
  Ways ways = Ways::kInOneGo;
  SearchProblem problem = make_problem(belief_, ways);
  const std::size_t count = friction_.frictions().size();
  const auto levels = static_cast<double>(
      std::min(problem.available.size(), static_cast<std::size_t>(options_.search.horizon)));
  const bool was_turning = last_ways_ == Ways::kTurningToo && may_turn_over();
  if (auto found = was_turning ? rest_that_holds(make_problem(belief_, last_ways_), last_ways_, levels)
                               : rest_that_holds(problem, ways, levels))
    return *found;
  SearchResult best;
  double most = 0.0;
  const auto sure = [&] { return most >= options_.sure_success * levels; };
  const auto search = [&](std::size_t level, bool way_up_only) {
    SearchProblem here = problem;
    here.way_up_only = way_up_only;
    if (!best.best.empty()) here.way_up = plan_of(best.best.front());
    if (static_cast<double>(here.way_up.size()) >= levels) here.way_up.clear();  // it is whole, but doubtful
    if (way_up_only && here.way_up.empty()) return;
    const SearchOptions options = search_at(level, ways);
    SearchResult found = find_next_pose(here, options, hooks_.report);
    if (way_up_only && (found.best.empty() || plan_of(found.best.front()).size() <= here.way_up.size()))
      return;
    const double expected = found.best.empty() ? 0.0 : outlook(problem, found.best.front(), level);
    report(concat("friction ", options.friction, ways == Ways::kTurningToo ? ", stones turned over: " : ": ",
                  found.best.empty() ? found.reason
                                     : concat(std::round(10 * expected) / 10, " of ", levels,
                                              " stones are expected to stand")));
    if (!best.best.empty() && expected <= most) return;
    most = expected;
    last_level_ = level;
    last_ways_ = ways;
    best = std::move(found);
  };
  const auto climb = [&](std::size_t level) {
    const double before = most;
    search(level, false);
    for (std::size_t higher = level + 1; higher < count && most > before && !sure(); ++higher)
      search(higher, true);
  };
  for (std::size_t level = first_level(); level < count && !sure(); ++level) {
    climb(level);
    if (level + 1 < std::min(kInOneGoFirst, count) || ways == Ways::kTurningToo || sure() || !may_turn_over())
      continue;
    ways = Ways::kTurningToo;
    problem = make_problem(belief_, ways);
    climb(level);
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
  name_useless_grasps(&task, placement.stone);
  target.plan = plan_pick_and_place(target.scene, task, reach_in(belief_)->options_for(placement.stone));
  result_.seconds.planning += watch.seconds();
  if (target.plan.status == PickAndPlacePlan::Status::kPlanned) {
    if (reach_in(belief_)->is_low(placement.stone)) feel_to_grasp(target.plan, placement.stone);
    return target;
  }
  *refusal = target.plan.reason;
  auto& no_pick = no_pick_[placement.stone];
  no_pick.insert(no_pick.end(), target.plan.no_pick.begin(), target.plan.no_pick.end());
  if (!target.plan.no_pick.empty()) reach_.reset();  // it may count on these
  return std::nullopt;
}

void Builder::feel_to_grasp(PickAndPlacePlan& plan, int stone) const {
  report(concat(name(stone), " is held only with finger tips near the table: the hand feels its way down"));
  const auto approach = std::find_if(plan.steps.begin(), plan.steps.end(), [](const PlanStep& step) {
    return step.kind == PlanStep::Kind::kApproach;
  });
  if (approach != plan.steps.end()) approach->threshold = options_.motion.early_threshold;
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

}  // namespace stonestack::stacking
