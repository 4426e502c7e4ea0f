#pragma once
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack::search {

/// find_next_pose for a problem that was checked and whose stack is known to stand as it is given.
[[nodiscard]] SearchResult search_on_stack(const SearchProblem& problem, const SearchOptions& options,
                                           const std::function<void(const std::string&)>& report);

}  // namespace stonestack::search
