#include "stacking/choose_placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "search/parallel.hpp"
#include "stacking/choose_in_wall.hpp"
#include "stacking/free_places.hpp"
#include "stacking/settle_stack.hpp"
#include "stacking/unstack_depth.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr std::size_t kDirectFirst = 3;  // frictions at which no stone is reoriented: that takes 25 s each
constexpr std::size_t kMaxRefused = 12;  // poses without a motion, after which no others are searched for
constexpr std::size_t kMaxOffWall = 2;   // stones that are taken off a wall at once: each is a plan of it
constexpr double kSamePlace = 0.012;     // m, of the centre of mass: nearer is what was tried before
constexpr double kSameTurn = 0.26;       // rad: the same

std::vector<PlacedStone> plan_of(const Placement& first) {
  std::vector<PlacedStone> plan{{first.stone, first.T_W_O}};
  plan.insert(plan.end(), first.then.begin(), first.then.end());
  return plan;
}

/// The placements whose plans reach highest, then the others: one that leads nowhere does not go before one
/// for which a stone must be reoriented.
std::array<std::vector<Placement>, 2> by_plan_length(const std::vector<Placement>& found) {
  std::size_t longest = 0;
  for (const Placement& placement : found) longest = std::max(longest, placement.then.size());
  std::array<std::vector<Placement>, 2> parts;
  for (const Placement& placement : found)
    parts[placement.then.size() < longest ? 1 : 0].push_back(placement);
  return parts;
}

/// Of the possible frictions the one that a search begins with.
std::size_t first_level(const std::vector<bool>& possible, const FrictionEstimate& friction) {
  if (possible[0] && min_is_likeliest(friction)) return 0;
  for (std::size_t level = 1; level < possible.size(); ++level)
    if (possible[level]) return level;
  return 0;
}

/// The mean over the possible frictions, by how likely each is.
double weighted_mean(const std::vector<double>& expected, const std::vector<bool>& possible,
                     const FrictionEstimate& friction) {
  double sum = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    if (!possible[k]) continue;
    weights += friction.weights[k];
    sum += friction.weights[k] * expected[k];
  }
  return sum / weights;
}

/// Nothing was found to fit on that stone when it lay nearly there, or no motion brings it there.
bool was_given_up(const ShapeList& shapes, const RunMemory& memory, const PlacedStone& placed) {
  const auto same = [&](const PlacedStone& top) {
    return same_place(shapes, top, placed, kSamePlace, kSameTurn);
  };
  return std::any_of(memory.given_up.begin(), memory.given_up.end(), same) ||
         std::any_of(memory.refused.begin(), memory.refused.end(), same);
}

std::vector<Pose> useless_grasps(const RunMemory& memory, StoneIndex stone) {
  std::vector<Pose> list = failed_twice(memory, stone);
  if (const auto none = memory.no_pick.find(stone); none != memory.no_pick.end())
    list.insert(list.end(), none->second.begin(), none->second.end());
  return list;
}

std::shared_ptr<Reach> make_reach(const Arrangement& arrangement, const WorldEstimate& world,
                                  const Models& models, const BuildOptions& options) {
  return std::make_shared<Reach>(
      arrangement, make_planning_scene(world.layout, *models.robot, *models.catalogue, arrangement),
      *models.catalogue, options.motion);
}

/// Tower or wall are seen to stand, and by their models they do at no friction.
bool cannot_rest(const Situation& s) {
  return !s.arrangement.stack.empty() && !stands_at_some_friction(s.world.resting);
}

/// How many of `stones` more are planned upon `standing` ones: none above the height that was asked for.
int levels_ahead(const BuildOptions& options, std::size_t standing, int stones) {
  if (options.max_stones <= 0) return stones;
  return std::clamp(options.max_stones - static_cast<int>(standing), 1, std::max(1, stones));
}

bool fits_gripper(const Models& models, StoneIndex stone) {
  return at(models.unfit, stone).empty();
}

/// One search over the assumed frictions.
struct FrictionSearch {
  const Situation& s;
  const RunMemory& memory;
  std::vector<bool> possible = possible_frictions(s.world);

  [[nodiscard]] SearchProblem problem(Route route) const {
    return make_problem(s, memory, s.arrangement, s.reach, route);
  }

  /// Stones that are expected to stand by a placement and what is to follow it, over all possible frictions;
  /// `level` of them was assumed by the search that found it.
  [[nodiscard]] double expected_over_frictions(const SearchProblem& problem, const Placement& found,
                                               std::size_t level) const {
    std::vector<bool> asked = possible;
    asked[level] = false;
    std::vector<double> expected = expected_by_friction(problem, plan_of(found), memory.friction.frictions,
                                                        asked, &s.world.resting, s.options.search);
    expected[level] = found.expected_height;
    return weighted_mean(expected, possible, memory.friction);
  }

  /// The rest of the followed plan, if it still holds: at the friction it was found with, or at a higher one
  /// where the whole of it is still expected to stand.
  [[nodiscard]] std::optional<SearchOutcome> rest_that_holds(const SearchProblem& problem, Route route,
                                                             double levels) const {
    const std::vector<PlacedStone> plan = rest_of_plan(s, memory.plan);
    if (plan.empty()) return std::nullopt;
    const std::size_t first = memory.plan->friction_level;
    for (std::size_t level = first; level < possible.size(); ++level) {
      const SearchOptions search = options_at(s.options, memory.friction, level, route);
      SearchResult found;
      if (const auto here = at_friction(problem, s.world.resting[level]))
        found = follow_plan(*here, plan, search);
      else
        found.reason = s.world.resting[level].reason;
      if (found.best.empty()) {
        s.emit(PlanBroken{search.friction, found.reason});
        if (found.unreachable > 0) break;  // by no friction will it be
        continue;
      }
      if ((level > first || memory.friction_measured) &&
          expected_over_frictions(problem, found.best.front(), level) < s.options.sure_success * levels)
        break;
      s.emit(PlanHolds{search.friction});
      add_compared(found);
      SearchOutcome outcome;
      outcome.found = std::move(found);
      outcome.friction_level = level;
      outcome.route = memory.plan->route;
      return outcome;
    }
    return std::nullopt;
  }

  /// Alternatives to the stones of the followed plan, from the search that made it.
  void add_compared(SearchResult& found) const {
    std::vector<std::vector<Alternative>> compared = compared_with_rest(s, *memory.plan);
    Placement& next = found.best.front();
    if (compared.size() != next.then.size() + 1) return;
    found.others = std::move(compared.front());
    next.then_compared.assign(std::make_move_iterator(compared.begin() + 1),
                              std::make_move_iterator(compared.end()));
  }

  /// Faults of the grasps of each stone that the search could have used: "; NAME: of 212 grasps ...".
  [[nodiscard]] std::string refusals(const SearchProblem& problem) const {
    std::string text;
    for (const PlacedStone& loose : problem.available)
      if (const std::string why = s.reach->refusal(loose.stone); !why.empty())
        text += concat("; ", s.models.name(loose.stone), ": ", why);
    return text;
  }

  /// A plan that still holds needs no search. Otherwise what holds with little friction first, but not the
  /// lowest, with which towers of four are rarely found (it counts in the expected height); more is assumed
  /// as long as the tower found so far is not expected to stand whole: first to go on from where it ends,
  /// then for other towers. From the third friction on, or the last, stones may be reoriented.
  /// Nothing where the first search finds nothing and the world is a prediction.
  [[nodiscard]] std::optional<SearchOutcome> run() const {
    Route route = Route::kDirect;
    SearchProblem current = problem(route);
    if (current.held > 0)
      s.emit(SearchProgress{"the tower stands, though by its models it cannot: it is held where it is seen"});
    const std::size_t count = possible.size();
    const int horizon = levels_ahead(s.options, s.arrangement.stack.size(), s.options.search.horizon);
    const auto levels =
        static_cast<double>(std::min(current.available.size(), static_cast<std::size_t>(horizon)));
    const bool reorients_allowed = may_reorient(memory, s.options);
    const bool was_reorienting =
        memory.plan && memory.plan->route == Route::kReorienting && reorients_allowed;
    if (auto found = was_reorienting
                         ? rest_that_holds(problem(Route::kReorienting), Route::kReorienting, levels)
                         : rest_that_holds(current, route, levels))
      return found;
    SearchOutcome best;
    double best_expected = 0.0;
    const auto sure = [&] { return best_expected >= s.options.sure_success * levels; };
    const auto search = [&](std::size_t level, bool known_route_only) {
      SearchProblem here = current;
      here.known_route_only = known_route_only;
      if (!best.found.best.empty()) here.known_route = plan_of(best.found.best.front());
      if (static_cast<double>(here.known_route.size()) >= levels)
        here.known_route.clear();  // complete, but unlikely to stand
      if (known_route_only && here.known_route.empty()) return;
      SearchOptions options = options_at(s.options, memory.friction, level, route);
      options.horizon = horizon;
      SearchResult found;
      if (const auto resting = at_friction(here, s.world.resting[level]))
        found =
            find_next_pose(*resting, options, [&](const std::string& line) { s.emit(SearchProgress{line}); });
      else
        found.reason = s.world.resting[level].reason;
      if (known_route_only &&
          (found.best.empty() || plan_of(found.best.front()).size() <= here.known_route.size()))
        return;
      const bool any = !found.best.empty();
      const double expected = any ? expected_over_frictions(current, found.best.front(), level) : 0.0;
      s.emit(SearchedAtFriction{options.friction, route, any, expected, levels, found.reason});
      if (!best.found.best.empty() && expected <= best_expected) return;
      best_expected = expected;
      best.friction_level = level;
      best.route = route;
      best.found = std::move(found);
    };
    const auto climb = [&](std::size_t level) {
      const double before = best_expected;
      search(level, false);
      for (std::size_t higher = level + 1; higher < count && best_expected > before && !sure(); ++higher)
        search(higher, true);
    };
    for (std::size_t level = first_level(possible, memory.friction); level < count && !sure(); ++level) {
      climb(level);
      if (best.found.best.empty() && s.basis == Basis::kPredicted) return std::nullopt;
      if (level + 1 < std::min(kDirectFirst, count) || route == Route::kReorienting || sure() ||
          !reorients_allowed)
        continue;
      route = Route::kReorienting;
      current = problem(route);
      climb(level);
    }
    if (!best.found.best.empty() && s.options.search.verify && best_expected < s.options.min_expected) {
      best.found.best.clear();
      best.found.reason =
          concat("by the best tower found only ", std::round(100 * best_expected) / 100,
                 " more stones are expected to stand (minimum: ", s.options.min_expected, ")");
    }
    if (best.found.best.empty() && best.found.unreachable > 0) best.found.reason += refusals(current);
    return best;
  }
};

/// Loose stones that no grasp holds as they lie, and why.
std::vector<StoneNote> not_held(const Situation& s) {
  std::vector<StoneNote> list;
  for (const PlacedStone& loose : s.arrangement.loose) {
    const std::string& unfit = at(s.models.unfit, loose.stone);
    if (!unfit.empty())
      list.push_back({loose.stone, unfit});
    else if (!s.reach->at_pick(loose.stone).can_be_held())
      list.push_back({loose.stone, s.reach->at_pick(loose.stone).text()});
  }
  return list;
}

/// The search's result that holds for this world: what is known, or found now.
void search_now(const Situation& s, RunMemory& memory) {
  std::vector<StoneIndex> graspable = graspable_stones(s);
  if (memory.search && memory.search->graspable == graspable) return;
  if (graspable.empty()) {
    std::string stones;
    for (const StoneNote& stone : not_held(s))
      stones += concat(stones.empty() ? "" : "; ", s.models.name(stone.stone), ": ", stone.note);
    memory.search = SearchOutcome{};
    memory.search->dead_end = {RunEnd::kNoPose,
                               "no feasible pose: the gripper cannot pick up what is left: " + stones};
    return;
  }
  memory.search = s.models.wall ? search_wall(s, memory) : FrictionSearch{s, memory}.run();
  if (!memory.search) return;
  memory.search->graspable = std::move(graspable);
  if (memory.search->found.best.empty() && !memory.search->dead_end)
    memory.search->dead_end = {RunEnd::kNoPose, "no feasible pose: " + memory.search->found.reason};
}

/// The stages of a search's result, in order: direct and, if it counted on that, with reorienting.
std::vector<Action> stages_of(const SearchOutcome& outcome) {
  std::vector<Action> stages;
  for (const std::vector<Placement>& part : by_plan_length(outcome.found.best)) {
    if (part.empty()) continue;
    stages.emplace_back(Place{part});
    if (outcome.route == Route::kReorienting) stages.emplace_back(Reorient{part});
  }
  return stages;
}

/// The arrangement when the top `count` stones lie in the field; empty when they do not fit.
std::optional<Arrangement> without_top(const Situation& s, std::size_t count) {
  Arrangement lower = s.arrangement;
  for (std::size_t k = 0; k < count; ++k) {
    const PlacedStone top = lower.stack.back();
    const auto places = free_places(s.models.shapes, s.world.layout, lower, top);
    if (places.empty()) return std::nullopt;
    lower.stack.pop_back();
    lower.loose.push_back({top.stone, places.front()});
  }
  return lower;
}

/// Stones that are expected to stand in the end if the tower goes on from `lower`; 0 where the search finds
/// none higher than the stack.
double expected_from(const Situation& s, const RunMemory& memory, const Arrangement& lower) {
  const Route route = may_reorient(memory, s.options) ? Route::kReorienting : Route::kDirect;
  SearchProblem problem =
      make_problem(s, memory, lower, make_reach(lower, s.world, s.models, s.options), route);
  if (problem.available.empty()) return 0.0;
  if (s.models.wall) return expected_in_wall(s, memory, problem, route);
  const int levels = levels_ahead(s.options, lower.stack.size(), static_cast<int>(problem.available.size()));
  const std::vector<bool> possible = possible_frictions(s.world);
  double best_expected = 0.0;
  bool higher = false;
  for (std::size_t level = first_level(possible, memory.friction);
       level < possible.size() && best_expected < s.options.sure_success * levels; ++level) {
    const auto tower =
        plan_tower(problem, levels, options_at(s.options, memory.friction, level, route)).placements;
    problem.known_route.clear();
    for (const Placement& placement : tower)
      problem.known_route.push_back({placement.stone, placement.T_W_O});
    if (lower.stack.size() + tower.size() <= s.arrangement.stack.size()) continue;
    higher = true;
    best_expected =
        std::max(best_expected,
                 weighted_mean(expected_by_friction(problem, problem.known_route, memory.friction.frictions,
                                                    possible, nullptr, s.options.search),
                               possible, memory.friction));
    if (static_cast<int>(tower.size()) == levels)
      problem.known_route.clear();  // complete, but unlikely to stand
  }
  return higher ? static_cast<double>(lower.stack.size()) + best_expected : 0.0;
}

}  // namespace

std::vector<bool> possible_frictions(const WorldEstimate& world) {
  const bool any = stands_at_some_friction(world.resting);
  std::vector<bool> possible;
  for (const RestingStack& at : world.resting) possible.push_back(at.stack.has_value() || !any);
  return possible;
}

std::vector<Pose> failed_twice(const RunMemory& memory, StoneIndex stone) {
  std::vector<Pose> once, twice;
  if (const auto failed = memory.failed_grasps.find(stone); failed != memory.failed_grasps.end())
    for (const Pose& T_O_T : failed->second) (is_near_grasp(once, T_O_T) ? twice : once).push_back(T_O_T);
  return twice;
}

SearchProblem make_problem(const Situation& s, const RunMemory& memory, const Arrangement& arrangement,
                           const std::shared_ptr<Reach>& reach, Route route) {
  SearchProblem problem;
  problem.shapes = &s.models.shapes;
  problem.possible_shapes = &s.models.possible_shapes;
  problem.stack.stones = arrangement.stack;
  if (cannot_rest(s)) problem.held = static_cast<int>(arrangement.stack.size());
  problem.site = s.world.layout.site;
  for (const PlacedStone& loose : arrangement.loose)
    if (fits_gripper(s.models, loose.stone) && reach->at_pick(loose.stone).can_be_held())
      problem.available.push_back(loose);
  problem.reachable = [&shapes = s.models.shapes, &memory, reach, route, loose = arrangement.loose](
                          StoneIndex stone, const Pose& T_W_O, const Stack& below) {
    if (was_given_up(shapes, memory, {stone, T_W_O}) ||
        leans_on_loose(shapes, loose, {stone, T_W_O}, below.stones))
      return false;
    const std::vector<Pose> avoid = useless_grasps(memory, stone);
    return reach->in_one_go(stone, T_W_O, below, avoid) ||
           (route == Route::kReorienting &&
            reach->by_reorienting(stone, T_W_O, below, avoid, regrasp_options(memory, stone)));
  };
  return problem;
}

std::optional<SearchProblem> at_friction(const SearchProblem& problem, const RestingStack& resting) {
  if (problem.held > 0) return problem;
  if (!resting.stack) return std::nullopt;
  SearchProblem there = problem;
  there.stack = *resting.stack;
  there.stack_is_at_rest = true;
  return there;
}

SearchOptions options_at(const BuildOptions& options, const FrictionEstimate& friction, std::size_t level,
                         Route route) {
  SearchOptions search = options.search;
  search.friction = friction.frictions[level];
  if (route == Route::kReorienting) search.max_tilt = M_PI;
  if (level + 1 < friction.frictions.size()) search.rounds = std::min(search.rounds, options.first_rounds);
  return search;
}

std::vector<PlacedStone> rest_of_plan(const Situation& s, const std::optional<FollowedPlan>& plan) {
  if (!plan) return {};
  const Placement& last = plan->placement;
  const auto is_last = [&](const PlacedStone& stone) { return stone.stone == last.stone; };
  const auto& [stack, loose] = s.arrangement;
  if (stack.size() == plan->stack_before && std::any_of(loose.begin(), loose.end(), is_last))
    return plan_of(last);  // it was not picked: another grasp may do
  if (stack.empty() || !is_last(stack.back())) return {};
  if (s.models.wall) return last.then;
  const Pose moved = stack.back().T_W_O * last.T_W_O.inverse();
  std::vector<PlacedStone> rest = last.then;
  for (PlacedStone& next : rest) next.T_W_O = moved * next.T_W_O;
  return rest;
}

std::vector<std::vector<Alternative>> compared_with_rest(const Situation& s, const FollowedPlan& plan) {
  const Placement& last = plan.placement;
  const auto& stack = s.arrangement.stack;
  std::vector<std::vector<Alternative>> compared = last.then_compared;
  const bool was_placed = !stack.empty() && stack.back().stone == last.stone;
  if (!was_placed) compared.insert(compared.begin(), plan.compared);
  if (was_placed && !s.models.wall) {
    const Pose moved = stack.back().T_W_O * last.T_W_O.inverse();
    for (auto& list : compared)
      for (Alternative& other : list) other.T_W_O = moved * other.T_W_O;
  }
  return compared;
}

Situation make_situation(const WorldEstimate& world, const Models& models, const BuildOptions& options,
                         const Listener& listener, Basis basis) {
  Arrangement arrangement = at_rest(world);
  auto reach = make_reach(arrangement, world, models, options);
  return {world, models, options, listener, std::move(arrangement), std::move(reach), basis};
}

std::vector<StoneIndex> graspable_stones(const Situation& s) {
  std::vector<StoneIndex> stones;
  for (const PlacedStone& loose : s.arrangement.loose)
    if (fits_gripper(s.models, loose.stone) && s.reach->at_pick(loose.stone).can_be_held())
      stones.push_back(loose.stone);
  return stones;
}

RegraspOptions regrasp_options(const RunMemory& memory, StoneIndex stone) {
  RegraspOptions regrasp;
  regrasp.max_set_downs = 1;
  if (const auto fell = memory.toppled.find(stone); fell != memory.toppled.end())
    regrasp.n_O_not_up = fell->second;
  return regrasp;
}

bool may_reorient(const RunMemory& memory, const BuildOptions& options) {
  return memory.reoriented < options.max_reoriented;
}

bool height_is_reached(const Arrangement& arrangement, const BuildOptions& options) {
  return options.max_stones > 0 && static_cast<int>(arrangement.stack.size()) >= options.max_stones;
}

std::vector<double> expected_by_friction(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                                         const std::vector<double>& frictions, const std::vector<bool>& asked,
                                         const std::vector<RestingStack>* resting,
                                         const SearchOptions& options) {
  SearchProblem here = problem;
  here.reachable = nullptr;  // it was asked when the plan was made
  std::vector<double> expected(frictions.size(), 0.0);
  run_tasks(options.threads, frictions.size(), [&](std::size_t k) {
    if (!asked[k]) return;
    SearchOptions other = options;
    other.threads = 1;
    other.friction = frictions[k];
    other.min_success = other.min_margin = 0.0;  // an expectation: nothing is chosen by it
    const auto there = resting == nullptr ? here : at_friction(here, (*resting)[k]);
    if (there) expected[k] = expected_height(*there, plan, other);
  });
  return expected;
}

std::optional<Action> choose_placement(const Situation& s, RunMemory& memory) {
  s.emit(StonesNotHeld{not_held(s)});
  for (;;) {
    throw_if_interrupted();
    search_now(s, memory);
    if (!memory.search) return std::nullopt;
    SearchOutcome& outcome = *memory.search;
    if (outcome.dead_end) return std::nullopt;
    const std::vector<Action> stages = stages_of(outcome);
    if (outcome.refused < static_cast<int>(stages.size()))
      return stages[static_cast<std::size_t>(outcome.refused)];
    if (!rest_of_plan(s, memory.plan).empty()) {
      s.emit(PlanAbandoned{outcome.refusals});
      memory.plan.reset();
    } else if (memory.refused.size() < kMaxRefused) {  // other poses then, of other stones perhaps
      s.emit(PosesRefused{outcome.found.best.size(), outcome.refusals});
      for (const auto& placement : outcome.found.best)
        memory.refused.push_back({placement.stone, placement.T_W_O});
    } else {
      outcome.dead_end = {RunEnd::kNoPlan, concat("none of ", outcome.found.best.size(),
                                                  " poses can be reached: ", outcome.refusals)};
      return std::nullopt;
    }
    memory.search.reset();
  }
}

std::vector<double> expected_unstacked(const Situation& s, const RunMemory& memory) {
  auto allowed = static_cast<std::size_t>(std::max(0, s.options.max_unstacked - memory.unstacked));
  if (s.models.wall) allowed = std::min(allowed, kMaxOffWall);
  const std::size_t stack = s.arrangement.stack.size();
  const auto all = static_cast<double>(stack + s.arrangement.loose.size());
  std::vector<double> expected;
  while (expected.size() < std::min(allowed, stack)) {
    auto at_best = expected;
    at_best.push_back(all);
    if (unstack_depth(at_best, stack) <= expected.size()) break;  // one deeper cannot pay
    const auto lower = without_top(s, expected.size() + 1);
    expected.push_back(lower ? expected_from(s, memory, *lower) : 0.0);
  }
  return expected;
}

}  // namespace stonestack::stacking
