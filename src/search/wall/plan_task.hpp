#pragma once
#include "search/wall/wall_state.hpp"

namespace stonestack::search {

/// As plan_wall, for a target with a task that was checked.
/// @throws InvalidArgument where the arm is asked and the task has supports, which the arm knows nothing of
[[nodiscard]] WallPlan plan_task(const SearchProblem& problem, const WallTarget& target,
                                 const SearchOptions& options,
                                 const std::function<void(const std::string&)>& report,
                                 const std::optional<WallBegun>& begun);
/// As measure_wall, likewise.
[[nodiscard]] WallMetrics measure_task(const SearchProblem& problem, const SpanTask& task,
                                       const WallBegun& begun, const SearchOptions& options);

}  // namespace stonestack::search
