#include "stonestack/search/find_next_pose.hpp"

#include "search/default_search.hpp"
#include "search/paper_search.hpp"
#include "search/search_on_stack.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

/// A problem on a stack that is known to stand.
struct StandingProblem {
  std::optional<SearchProblem> problem;
  std::string reason;  ///< why it does not stand, if it is empty
};

StandingProblem settled_problem(const SearchProblem& problem, const SearchOptions& options) {
  check_problem(problem, options);
  if (problem.stack_is_at_rest || problem.held > 0) return {problem, ""};
  try {
    StandingStack at_rest = settled_stack(*problem.shapes, problem.stack, options);
    if (!at_rest.stack) return {std::nullopt, std::move(at_rest.reason)};
    SearchProblem standing = problem;
    standing.stack = *std::move(at_rest.stack);
    return {std::move(standing), ""};
  } catch (const Interrupted&) {
    return {std::nullopt, why_interrupted()};
  }
}

SearchResult without_poses(std::string reason) {
  SearchResult result;
  result.reason = std::move(reason);
  return result;
}

}  // namespace

SearchResult search_on_stack(const SearchProblem& problem, const SearchOptions& options,
                             const std::function<void(const std::string&)>& report) {
  const SearchContext context = make_context(problem, options, report);
  if (context.available.empty()) return without_poses("no loose stone is left");
  SearchResult result = options.method == "paper" ? paper_search(context) : default_search(context);
  if (result.best.empty() && context.out_of_time()) result.reason = kTimeOver;
  result.seconds = context.watch.seconds();
  return result;
}

SearchResult find_next_pose(const SearchProblem& problem, const SearchOptions& options,
                            const std::function<void(const std::string&)>& report) {
  StandingProblem standing = settled_problem(problem, options);
  if (!standing.problem) return without_poses(std::move(standing.reason));
  return search_on_stack(*standing.problem, options, report);
}

SearchResult follow_plan(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                         const SearchOptions& options) {
  StandingProblem standing = settled_problem(problem, options);
  if (!standing.problem) return without_poses(std::move(standing.reason));
  return follow_plan(make_context(*standing.problem, options, {}), plan);
}

double expected_height(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                       const SearchOptions& options) {
  const StandingProblem standing = settled_problem(problem, options);
  return standing.problem ? expected_of_plan(make_context(*standing.problem, options, {}), plan) : 0.0;
}

}  // namespace stonestack::search
