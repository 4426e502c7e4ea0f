#pragma once
#include <span>

#include "search/search_context.hpp"

namespace stonestack::search {

/// How far a stone may turn about level axes when it is put down, since its surface and that of the stones
/// below it are known in part only: standard deviation [rad] over the shapes that they may have, each of
/// which rests on the same contacts. 0 where all surface is known, as that on which a stone lay on the table.
/// @param contacts of the stone with the stack `below` or the table
[[nodiscard]] double rest_uncertainty(const SearchContext& context, const Stack& below,
                                      const PlacedStone& placed, std::span<const Contact> contacts);

}  // namespace stonestack::search
