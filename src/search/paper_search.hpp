#pragma once
#include "search/verification.hpp"

namespace stonestack::search {

/// Section 3 of the paper: for every available stone, random initial orientations until x local solutions are
/// found, each refined by descent; the least cost of all stones wins.
void paper_search(const SearchContext& context, SearchResult* result);

}  // namespace stonestack::search
