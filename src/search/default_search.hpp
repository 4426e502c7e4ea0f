#pragma once
#include "search/look_ahead.hpp"
#include "search/verification.hpp"

namespace stonestack {

/// Gap field proposals, look-ahead, reach, verification. Fills `result` as it goes, so that what was found
/// when it is interrupted is kept.
void default_search(const SearchContext& context, const LookAhead& look_ahead, SearchResult* result);

}  // namespace stonestack
