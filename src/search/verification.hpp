#pragma once
#include "search/trial.hpp"

namespace stonestack::search {

/// Settles the trials (all at once), then judges the best one after another in waves until
/// `alternatives` are good or all are judged; the good ones become `result->best`, most worth first.
void verify(const SearchContext& context, std::vector<Trial> trials, SearchResult* result);

}  // namespace stonestack::search
