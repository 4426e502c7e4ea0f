#include "stonestack/search/find_next_pose.hpp"

#include "search/default_search.hpp"
#include "search/paper_search.hpp"
#include "search/search_on_stack.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

/// Searches on a stack that is known to stand; Ctrl-C ends it with what there is.
void search(const SearchContext& context, SearchResult* result) {
  try {
    if (context.options->method == "paper") {
      paper_search(context, result);
    } else {
      default_search(context, result);
    }
  } catch (const Interrupted&) {
    if (result->best.empty()) result->reason = why_interrupted();
  }
  if (result->best.empty() && context.out_of_time()) result->reason = kTimeOver;
  result->seconds = context.watch.seconds();
}

/// The problem on a stack that is known to stand; empty, with the reason, if it does not.
std::optional<SearchProblem> settled_problem(const SearchProblem& problem, const SearchOptions& options,
                                             SearchResult* result) {
  check_problem(problem, options);
  if (problem.stack_is_at_rest) return problem;
  try {
    const auto stack = settled_stack(*problem.shapes, problem.stack, options, &result->reason);
    if (!stack) return std::nullopt;
    SearchProblem standing = problem;
    standing.stack = *stack;
    return standing;
  } catch (const Interrupted&) {
    result->reason = why_interrupted();
    return std::nullopt;
  }
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
  SearchResult result;
  const auto standing = settled_problem(problem, options, &result);
  return standing ? search_on_stack(*standing, options, report) : result;
}

SearchResult follow_plan(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                         const SearchOptions& options) {
  SearchResult result;
  const auto standing = settled_problem(problem, options, &result);
  if (!standing) return result;
  try {
    follow_plan(make_context(*standing, options, {}), plan, &result);
  } catch (const Interrupted&) {
    result.reason = "interrupted before the plan was judged";
  }
  return result;
}

double expected_height(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                       const SearchOptions& options) {
  SearchResult unused;
  const auto standing = settled_problem(problem, options, &unused);
  return standing ? expected_of_plan(make_context(*standing, options, {}), plan) : 0.0;
}

}  // namespace stonestack::search
