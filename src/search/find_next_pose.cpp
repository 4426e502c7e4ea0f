#include "stonestack/search/find_next_pose.hpp"

#include <algorithm>

#include "search/default_search.hpp"
#include "search/paper_search.hpp"
#include "search/search_on_stack.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

bool in_stack(const Stack& stack, int stone) {
  return std::any_of(stack.stones.begin(), stack.stones.end(),
                     [&](const PlacedStone& placed) { return placed.stone == stone; });
}

SearchContext make_context(const SearchProblem& problem, const SearchOptions& options,
                           const std::function<void(const std::string&)>& report) {
  SearchContext context;
  context.problem = &problem;
  context.options = &options;
  context.report = report;
  context.stack = problem.stack;
  context.geometry.resize(problem.shapes->size());
  for (const auto* list : {&problem.stack.stones, &problem.available})
    for (const PlacedStone& placed : *list) {
      const auto k = static_cast<std::size_t>(placed.stone);
      if (context.geometry[k].faces.empty()) context.geometry[k] = stone_geometry(*(*problem.shapes)[k]);
    }
  for (const PlacedStone& placed : problem.available)
    if (!in_stack(problem.stack, placed.stone)) context.available.push_back(placed);
  return context;
}

/// Searches on a stack that is known to stand; Ctrl-C ends it with what there is.
void search(const SearchContext& context, SearchResult* result) {
  try {
    if (context.options->method == "paper") {
      paper_search(context, result);
    } else {
      const std::vector<LooseStone> loose = loose_stones(context);
      default_search(context, LookAhead(loose, *context.options), result);
    }
  } catch (const Interrupted&) {
    if (result->best.empty()) result->reason = "interrupted before a pose was found";
  }
  if (result->best.empty() && context.out_of_time())
    result->reason = "the time was over before a pose was found";
  result->seconds = context.watch.seconds();
}

}  // namespace

SearchResult search_on_stack(const SearchProblem& problem, const SearchOptions& options,
                             const std::function<void(const std::string&)>& report) {
  const SearchContext context = make_context(problem, options, report);
  SearchResult result;
  if (context.available.empty()) {
    result.reason = "no loose stone is left";
    return result;
  }
  search(context, &result);
  return result;
}

SearchResult find_next_pose(const SearchProblem& problem, const SearchOptions& options,
                            const std::function<void(const std::string&)>& report) {
  check_problem(problem, options);
  SearchResult result;
  SearchProblem standing = problem;
  try {
    const auto stack = standing_stack(*problem.shapes, problem.stack, options, &result.reason);
    if (!stack) return result;
    standing.stack = *stack;
  } catch (const Interrupted&) {
    result.reason = "interrupted before a pose was found";
    return result;
  }
  return search_on_stack(standing, options, report);
}

}  // namespace stonestack
