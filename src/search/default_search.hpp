#pragma once
#include "search/search_context.hpp"

namespace stonestack {

/// Plans towers of up to `horizon` levels and returns their first placements: those that lead highest, and of
/// these the likeliest to be finished, first. What was found when it is interrupted is kept.
void default_search(const SearchContext& context, SearchResult* result);

}  // namespace stonestack
