#pragma once
#include <span>

#include "search/search_context.hpp"

namespace stonestack::search {

/// Plans towers of up to `horizon` levels and returns their first placements: those that lead highest, and of
/// these the likeliest to be finished, first. What was found when it is interrupted is kept.
void default_search(const SearchContext& context, SearchResult* result);

/// Settles and judges a plan and nothing else: its first placement, or the reason why it does not hold.
void follow_plan(const SearchContext& context, std::span<const PlacedStone> plan, SearchResult* result);
/// The stones of a plan that are expected to stand, of as much of it as holds.
[[nodiscard]] double expected_of_plan(const SearchContext& context, std::span<const PlacedStone> plan);

}  // namespace stonestack::search
