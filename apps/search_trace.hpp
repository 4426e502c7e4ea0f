#pragma once
#include <string>

#include "rooms.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::apps {

/// Writes `DIR/candidates.json` (schema "stonestack.trace/1"): for every candidate its stone, its path to
/// contact as poses T_W_O, its support polygon, cost, terms and outcome. Makes the folder. Throws FileError.
void write_trace(const std::string& folder, const Catalogue& catalogue, const SearchResult& result);

}  // namespace stonestack::apps
