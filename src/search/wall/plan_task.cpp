#include "search/wall/plan_task.hpp"

#include <algorithm>

#include "search/wall/span_search.hpp"
#include "search/wall/span_state.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

/// A problem whose stack begins with the supports of a task.
struct SupportedProblem {
  ShapeList shapes;
  SearchProblem problem;
  WallBegun begun;
};

void put_supports(const SearchProblem& problem, const SpanTask& task, const WallBegun& begun,
                  SupportedProblem& made) {
  made.problem = problem;
  made.begun = begun;
  made.shapes = *problem.shapes;
  const TaskSupports supports = make_supports(task);
  std::vector<PlacedStone> first;
  for (std::size_t k = 0; k < supports.shapes.size(); ++k) {
    first.push_back({StoneIndex(static_cast<int>(made.shapes.size())), begun.T_W_V * supports.T_V_O[k]});
    made.shapes.push_back(supports.shapes[k]);
  }
  made.problem.shapes = &made.shapes;
  made.problem.stack.stones.insert(made.problem.stack.stones.begin(), first.begin(), first.end());
  if (problem.held > 0) made.problem.held += static_cast<int>(first.size());
  made.begun.courses.insert(made.begun.courses.begin(), first.size(), 0);
}

/// One more than the highest of what each stone rests on; 0 on the table or a support.
std::vector<int> courses_of(const std::vector<std::vector<int>>& upon, std::size_t supports) {
  std::vector<int> courses(upon.size(), 0);
  for (std::size_t k = supports; k < upon.size(); ++k)
    for (const int lower : upon[k])
      if (lower >= static_cast<int>(supports) && lower < static_cast<int>(k))
        courses[k] = std::max(courses[k], courses[static_cast<std::size_t>(lower)] + 1);
  return courses;
}

}  // namespace

WallPlan plan_task(const SearchProblem& problem, const WallTarget& target, const SearchOptions& options,
                   const std::function<void(const std::string&)>& report,
                   const std::optional<WallBegun>& begun) {
  const SpanTask& task = *target.task;
  require(!problem.reachable || task.supports.empty(),
          "the arm knows nothing of the supports of a target: plan without it, or put the blocks into the "
          "catalogue");
  WallBegun from = begun.value_or(WallBegun{frame_of(target, problem.site, 0.0), {}, {}});
  SupportedProblem with_supports;
  put_supports(problem, task, from, with_supports);
  SearchOptions of_task = options;
  of_task.yaws = std::min(options.yaws, 4);  // stones lie along the span or across it
  const SearchContext context = wall_context(with_supports.problem, of_task, report);
  const std::optional<Pose> T_W_V = from.T_W_V;
  Placing placing(context, T_W_V);
  const std::size_t supports = task.supports.size(), standing = with_supports.problem.stack.stones.size();
  SpanSearch search(context, task, standing_state(context, with_supports.begun), placing);
  search.run(from.rest, from.rest_only);
  const WallState& best = search.best();
  WallPlan plan;
  plan.T_W_V = from.T_W_V;
  plan.unreachable = placing.unreachable;
  plan.candidates = search.candidates();
  plan.metrics = span_metrics(context, task, best, supports);
  std::vector<std::vector<int>> upon = rests_upon(context, best);
  const std::vector<int> courses = courses_of(upon, supports);
  for (std::size_t k = standing; k < best.stones.size(); ++k) {
    std::erase_if(upon[k], [&](int lower) { return lower < static_cast<int>(supports); });
    for (int& lower : upon[k]) lower -= static_cast<int>(supports);
    plan.placements.push_back(
        in_world(plan.T_W_V, {best.trials[k].placement, courses[k], upon[k]}, best.compared[k]));
  }
  if (!search.done()) plan.reason = placing.reason.empty() ? "no more stones are left" : placing.reason;
  plan.seconds = context.watch.seconds();
  return plan;
}

WallMetrics measure_task(const SearchProblem& problem, const SpanTask& task, const WallBegun& begun,
                         const SearchOptions& options) {
  SupportedProblem with_supports;
  put_supports(problem, task, begun, with_supports);
  const SearchContext context = wall_context(with_supports.problem, options, {});
  return span_metrics(context, task, standing_state(context, with_supports.begun), task.supports.size());
}

}  // namespace stonestack::search
