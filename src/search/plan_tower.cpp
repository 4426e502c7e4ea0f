#include <algorithm>

#include "search/search_on_stack.hpp"
#include "search/tower_search.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack::search {
namespace {

/// One stone after the other, each the best of its level.
TowerPlan plan_greedily(SearchProblem problem, int levels, const SearchOptions& options) {
  const Stopwatch watch;
  SearchOptions of_level = options;
  of_level.alternatives = 1;
  of_level.horizon = 1;
  TowerPlan tower;
  for (int level = 0; level < levels && !interrupt_noted(); ++level) {
    if (options.budget > 0.0) of_level.budget = std::max(1e-3, options.budget - watch.seconds());
    const SearchResult found = search_on_stack(problem, of_level, {});
    if (found.best.empty()) {
      tower.reason = found.reason;
      break;
    }
    const Placement& next = found.best.front();
    problem.stack.stones.push_back({next.stone, next.T_W_O});
    std::erase_if(problem.available, [&](const PlacedStone& s) { return s.stone == next.stone; });
    tower.placements.push_back(next);
  }
  if (tower.reason.empty() && interrupt_noted()) tower.reason = time_is_over() ? kTimeOver : "interrupted";
  return tower;
}

TowerPlan plan_whole(const SearchProblem& problem, int levels, const SearchOptions& options,
                     const std::function<void(const std::string&)>& report) {
  const SearchContext context = make_context(problem, options, report);
  TowerSearch search(context, levels);
  TowerPlan tower;
  try {
    search.run();
  } catch (const Interrupted&) {
    tower.reason = time_is_over() ? kTimeOver : "interrupted";
  }
  const int top = search.best() > 0 ? search.best() : search.highest();
  for (const int k : search.tree().path_to(top)) {
    if (!search.tree().node(k).predicted) break;  // interrupted before that
    tower.placements.push_back(search.tree().node(k).trial.placement);
  }
  if (tower.reason.empty() && tower.placements.size() < static_cast<std::size_t>(levels))
    tower.reason = context.out_of_time() ? kTimeOver : search.reason();
  return tower;
}

}  // namespace

TowerPlan plan_tower(SearchProblem problem, int levels, const SearchOptions& options,
                     const std::function<void(const std::string&)>& report) {
  require(levels >= 0, "levels must not be negative, got ", levels);
  check_problem(problem, options);
  try {
    StandingStack at_rest{problem.stack, ""};
    if (problem.held == 0) at_rest = settled_stack(*problem.shapes, problem.stack, options);
    if (!at_rest.stack) return {{}, std::move(at_rest.reason)};
    if (levels == 0) return {};
    problem.stack = *std::move(at_rest.stack);
    const bool greedy = options.method == "paper" || options.horizon == 1;
    return greedy ? plan_greedily(std::move(problem), levels, options)
                  : plan_whole(problem, levels, options, report);
  } catch (const Interrupted&) {
    return {{}, why_interrupted()};
  }
}

}  // namespace stonestack::search
