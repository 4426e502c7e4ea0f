#pragma once
#include "search/verification.hpp"

namespace stonestack::search {

/// Section 3 of the paper: for every available stone, random initial orientations until x local solutions are
/// found, each refined by descent on eq. (2); the lowest cost of all stones wins. The only search that eq.
/// (2) ranks. What was found when it is interrupted is kept.
[[nodiscard]] SearchResult paper_search(const SearchContext& context);

}  // namespace stonestack::search
