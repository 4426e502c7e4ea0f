#pragma once
#include <optional>

#include "stacking/run_memory.hpp"

/// Private to stacking/: where a stone that is out of sight is looked for.
namespace stonestack::stacking {

/// Awaited stones that are nowhere to be seen.
[[nodiscard]] std::vector<StoneIndex> awaited_in_vain(const WorldEstimate& world, const RunMemory& memory);

/// The next view of a stone that was seen before and is not now: where it was, once a stone, then four places
/// beside the site, where a stone that fell off the tower may have rolled to. Nothing when no stone is
/// missing or all of these were tried since the last action.
[[nodiscard]] std::optional<LookAgain> next_view(const WorldEstimate& world, const RunMemory& memory);
/// Stones that were seen before and are not now, but for those that were looked for in vain.
[[nodiscard]] std::vector<StoneIndex> missing_stones(const WorldEstimate& world, const RunMemory& memory);

}  // namespace stonestack::stacking
