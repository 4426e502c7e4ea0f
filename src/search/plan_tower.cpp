#include <algorithm>

#include "search/search_on_stack.hpp"
#include "search/tower_search.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack::search {
namespace {

/// One stone after the other, each the best of its level.
std::vector<Placement> plan_greedily(SearchProblem problem, int levels, const SearchOptions& options,
                                     std::string* why) {
  const Stopwatch watch;
  SearchOptions of_level = options;
  of_level.alternatives = 1;
  of_level.horizon = 1;
  std::vector<Placement> tower;
  for (int level = 0; level < levels && !interrupt_noted(); ++level) {
    if (options.budget > 0.0) of_level.budget = std::max(1e-3, options.budget - watch.seconds());
    const SearchResult found = search_on_stack(problem, of_level, {});
    if (found.best.empty()) {
      *why = found.reason;
      break;
    }
    const Placement& next = found.best.front();
    problem.stack.stones.push_back({next.stone, next.T_W_O});
    std::erase_if(problem.available, [&](const PlacedStone& s) { return s.stone == next.stone; });
    tower.push_back(next);
  }
  if (why->empty() && interrupt_noted()) *why = time_is_over() ? kTimeOver : "interrupted";
  return tower;
}

std::vector<Placement> plan_whole(const SearchProblem& problem, int levels, const SearchOptions& options,
                                  const std::function<void(const std::string&)>& report, std::string* why) {
  const SearchContext context = make_context(problem, options, report);
  TowerSearch search(context, levels);
  try {
    search.run();
  } catch (const Interrupted&) {
    *why = time_is_over() ? kTimeOver : "interrupted";
  }
  std::vector<Placement> tower;
  const int top = search.best() > 0 ? search.best() : search.highest();
  for (const int k : search.tree().path_to(top)) {
    if (!search.tree().node(k).predicted) break;  // interrupted before that
    tower.push_back(search.tree().node(k).trial.placement);
  }
  if (why->empty() && tower.size() < static_cast<std::size_t>(levels))
    *why = context.out_of_time() ? kTimeOver : search.reason();
  return tower;
}

}  // namespace

std::vector<Placement> plan_tower(SearchProblem problem, int levels, const SearchOptions& options,
                                  std::string* reason,
                                  const std::function<void(const std::string&)>& report) {
  require(levels >= 0, "levels must not be negative, got ", levels);
  check_problem(problem, options);
  std::string why;
  std::vector<Placement> tower;
  try {
    if (const auto stack = settled_stack(*problem.shapes, problem.stack, options, &why)) {
      problem.stack = *stack;
      const bool greedy = options.method == "paper" || options.horizon == 1;
      why.clear();
      if (levels > 0)
        tower = greedy ? plan_greedily(std::move(problem), levels, options, &why)
                       : plan_whole(problem, levels, options, report, &why);
    }
  } catch (const Interrupted&) {
    why = why_interrupted();
  }
  if (reason != nullptr) *reason = why;
  return tower;
}

}  // namespace stonestack::search
