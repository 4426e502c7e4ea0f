#include "stacking/choose_in_wall.hpp"

#include <algorithm>
#include <numeric>

#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kJointForArm = 0.010;  // m between neighbours
constexpr double kMaxDoubt = 0.2;       // probability that the stones have less than the assumed friction
constexpr double kSureStone = 0.85;  // predicted success of every stone of a plan that is searched for first

int stones_of_target(const WallTarget& target) {
  return std::accumulate(target.courses.begin(), target.courses.end(), 0);
}

/// Of the frictions at which the wall can stand the highest that the stones have with enough probability; the
/// lowest, if there is none.
std::size_t first_friction(const std::vector<bool>& possible, const FrictionEstimate& friction) {
  std::size_t level = 0;
  while (level + 1 < possible.size() && !possible[level]) ++level;
  double less = std::accumulate(friction.weights.begin(),
                                friction.weights.begin() + static_cast<std::ptrdiff_t>(level), 0.0);
  for (std::size_t next = level; next + 1 < possible.size(); ++next) {
    less += friction.weights[next];
    if (less > kMaxDoubt) break;
    if (possible[next + 1]) level = next + 1;
  }
  return level;
}

std::size_t stones_present(const SearchProblem& problem) {
  return problem.stack.stones.size() + problem.available.size();
}

/// As much of a target as `stones` are enough for: from the table up.
WallTarget with_stones(WallTarget target, std::size_t stones) {
  int left = static_cast<int>(stones);
  for (int& count : target.courses) {
    count = std::min(count, left);
    left -= count;
  }
  std::erase(target.courses, 0);
  return target;
}

/// The highest friction at which the wall can stand.
std::size_t last_possible(const std::vector<bool>& possible) {
  const auto last = std::find(possible.rbegin(), possible.rend(), true);
  return static_cast<std::size_t>(possible.rend() - last) - 1;
}

int course_of(const WallPlanned& planned, StoneIndex stone) {
  const auto known = planned.course.find(stone);
  require(known != planned.course.end(), "no course was planned for stone ", stone, " of the wall");
  return known->second;
}

/// The wall that stands, in the courses that were planned.
WallBegun standing_wall(const WallPlanned& planned, const std::vector<PlacedStone>& stack) {
  WallBegun begun{planned.T_W_V, {}, {}};
  for (const PlacedStone& stone : stack) begun.courses.push_back(course_of(planned, stone.stone));
  return begun;
}

/// Stones that stand, and how the last plan meant to go on.
std::optional<WallBegun> begun_of(const Situation& s, const RunMemory& memory) {
  if (!memory.wall) return std::nullopt;
  WallBegun begun = standing_wall(*memory.wall, s.arrangement.stack);
  const std::vector<PlacedStone> rest = rest_of_plan(s, memory.plan);
  if (rest.empty()) return begun;
  const std::vector<std::vector<Alternative>> compared = compared_with_rest(s, *memory.plan);
  for (std::size_t k = 0; k < rest.size(); ++k) {
    WallPlacement planned;
    planned.placement.stone = rest[k].stone;
    planned.placement.T_W_O = rest[k].T_W_O;
    planned.course = course_of(*memory.wall, rest[k].stone);
    if (k < compared.size()) planned.alternatives = compared[k];
    begun.rest.push_back(std::move(planned));
  }
  return begun;
}

/// Stones of a plan that are expected to stay, each by itself.
double expected_stones(const WallPlan& plan) {
  double sum = 0.0;
  for (const WallPlacement& next : plan.placements) sum += next.placement.predicted_success;
  return sum;
}

/// The first stone of a plan, with those that follow it.
Placement first_of(const WallPlan& plan) {
  Placement first = plan.placements.front().placement;
  for (std::size_t k = 1; k < plan.placements.size(); ++k) {
    const WallPlacement& next = plan.placements[k];
    first.then.push_back({next.placement.stone, next.placement.T_W_O});
    first.then_compared.push_back(next.alternatives);
  }
  first.expected_height = expected_stones(plan);
  return first;
}

/// The plan with what it leads to, as the result of a search.
SearchOutcome outcome_of(const WallPlan& plan, const RunMemory& memory, std::size_t level, Route route) {
  SearchOutcome outcome;
  outcome.friction_level = level;
  outcome.route = route;
  outcome.found.reason = plan.reason;
  outcome.found.candidates = plan.candidates;
  outcome.found.unreachable = plan.unreachable;
  outcome.found.seconds = plan.seconds;
  if (plan.placements.empty()) return outcome;
  outcome.wall = memory.wall.value_or(WallPlanned{});
  outcome.wall->T_W_V = plan.T_W_V;
  for (const WallPlacement& next : plan.placements) outcome.wall->course[next.placement.stone] = next.course;
  outcome.found.best = {first_of(plan)};
  outcome.found.others = plan.placements.front().alternatives;
  return outcome;
}

/// The earlier plan, if all that is left of it still holds.
std::optional<SearchOutcome> rest_that_holds(const Situation& s, const RunMemory& memory,
                                             const WallTarget& target, std::optional<WallBegun> begun) {
  if (!begun || begun->rest.empty()) return std::nullopt;
  begun->rest_only = true;
  const std::size_t level = memory.plan->friction_level;
  const Route route = memory.plan->route;
  if (route == Route::kReorienting && !may_reorient(memory, s.options)) return std::nullopt;
  const auto here =
      at_friction(make_problem(s, memory, s.arrangement, s.reach, route), s.world.resting[level]);
  if (!here) return std::nullopt;
  const SearchOptions options = options_at(s.options, memory.friction, level, route);
  const WallPlan plan = plan_wall(*here, with_stones(target, stones_present(*here)), options, {}, begun);
  if (plan.placements.size() < begun->rest.size()) {
    s.emit(PlanBroken{options.friction, plan.reason});
    return std::nullopt;
  }
  s.emit(PlanHolds{options.friction});
  return outcome_of(plan, memory, level, route);
}

}  // namespace

WallTarget wall_for_arm(WallTarget target) {
  target.joint_gap = std::max(target.joint_gap, kJointForArm);
  return target;
}

bool wall_has_its_stones(const Situation& s) {
  if (!s.models.wall) return false;
  const int asked = stones_of_target(*s.models.wall);
  return asked > 0 && static_cast<int>(s.arrangement.stack.size()) >= asked;
}

Stop wall_stands(const Situation& s) {
  const bool spans = s.models.wall && s.models.wall->task;
  return {RunEnd::kHeightReached, concat(spans ? "the spans are closed with " : "the wall stands with ",
                                         s.arrangement.stack.size(), " stones")};
}

SearchOutcome search_wall(const Situation& s, const RunMemory& memory) {
  const WallTarget target = wall_for_arm(*s.models.wall);
  const std::optional<WallBegun> begun = begun_of(s, memory);
  if (auto rest = rest_that_holds(s, memory, target, begun)) return *std::move(rest);
  const std::vector<bool> possible = possible_frictions(s.world);
  const std::size_t first = first_friction(possible, memory.friction);
  const int asked = stones_of_target(target);
  const auto missing = static_cast<double>(asked > 0 ? asked - static_cast<int>(s.arrangement.stack.size())
                                                     : static_cast<int>(s.arrangement.loose.size()));
  struct Found {
    WallPlan plan;
    std::size_t level = 0;
    Route route = Route::kDirect;
    double expected = 0.0;
  };
  std::optional<Found> best;
  SearchOutcome nothing;
  const auto search = [&](std::size_t level, Route route, double min_success) {
    const SearchProblem problem = make_problem(s, memory, s.arrangement, s.reach, route);
    const auto here = at_friction(problem, s.world.resting[level]);
    if (!here) {
      nothing.found.reason = s.world.resting[level].reason;
      return;
    }
    SearchOptions options = options_at(s.options, memory.friction, level, route);
    options.min_success = std::max(options.min_success, min_success);
    WallPlan plan = plan_wall(
        *here, with_stones(target, stones_present(*here)), options,
        [&](const std::string& line) { s.emit(SearchProgress{line}); }, begun);
    const double expected = expected_stones(plan);
    s.emit(SearchedAtFriction{options.friction, route, !plan.placements.empty(), expected, missing,
                              plan.reason});
    const bool whole = plan.reason.empty(), best_whole = best && best->plan.reason.empty();
    if (best && (best_whole > whole || (best_whole == whole && expected <= best->expected))) return;
    best = Found{std::move(plan), level, route, expected};
  };
  const auto is_whole = [&] { return best && best->plan.reason.empty(); };
  // Firm stones first; then what may make the wall whole: more friction and stones that are less sure to
  // stay, or a stone that is turned on the way.
  for (const Route route : {Route::kDirect, Route::kReorienting})
    for (const bool firm : {true, false}) {
      if (is_whole() || (route == Route::kReorienting && !may_reorient(memory, s.options))) continue;
      search(firm ? first : last_possible(possible), route, firm ? kSureStone : 0.0);
    }
  if (!best) return nothing;
  SearchOutcome outcome = outcome_of(best->plan, memory, best->level, best->route);
  if (best->plan.placements.empty() && is_whole()) outcome.dead_end = wall_stands(s);
  return outcome;
}

double expected_in_wall(const Situation& s, const RunMemory& memory, const SearchProblem& problem,
                        Route route) {
  if (!memory.wall || s.models.wall->task) return 0.0;
  const std::size_t level = first_friction(possible_frictions(s.world), memory.friction);
  const WallTarget target = with_stones(wall_for_arm(*s.models.wall), stones_present(problem));
  const WallPlan plan = plan_wall(problem, target, options_at(s.options, memory.friction, level, route), {},
                                  standing_wall(*memory.wall, problem.stack.stones));
  const std::size_t standing = problem.stack.stones.size();
  if (standing + plan.placements.size() <= s.arrangement.stack.size()) return 0.0;
  return static_cast<double>(standing) + expected_stones(plan);
}

WallMetrics measure_wall(const Models& models, const Arrangement& arrangement, const RunMemory& memory,
                         SearchOptions options) {
  const FrictionEstimate& friction = memory.friction;
  options.friction =
      std::inner_product(friction.frictions.begin(), friction.frictions.end(), friction.weights.begin(), 0.0);
  SearchProblem problem;
  problem.shapes = &models.shapes;
  problem.stack.stones = arrangement.stack;
  WallMetrics metrics =
      search::measure_wall(problem, *models.wall, standing_wall(*memory.wall, arrangement.stack), options);
  metrics.asked = stones_of_target(*models.wall);
  return metrics;
}

}  // namespace stonestack::stacking
