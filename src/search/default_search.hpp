#pragma once
#include <span>

#include "search/search_context.hpp"

namespace stonestack::search {

/// Anytime beam search over towers (TowerSearch): plans towers of up to `horizon` levels and returns their
/// first placements, ranked by the levels that the best tower above each reaches, then by the chance that it
/// can be finished. Eq. (2) of the paper does not rank here: it is computed for each placement and reported
/// (`cost`, `terms`); it ranks in paper mode only (paper_search.hpp). What was found when it is interrupted
/// is kept.
[[nodiscard]] SearchResult default_search(const SearchContext& context);

/// Settles and judges a plan and nothing else: its first placement, or the reason why it does not hold.
[[nodiscard]] SearchResult follow_plan(const SearchContext& context, std::span<const PlacedStone> plan);
/// The stones of a plan that are expected to stand, of as much of it as holds.
[[nodiscard]] double expected_of_plan(const SearchContext& context, std::span<const PlacedStone> plan);

}  // namespace stonestack::search
