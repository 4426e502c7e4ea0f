#pragma once
#include "stacking/choose_placement.hpp"

/// Private to stacking/: pushes that bring a stone away from what keeps the fingers off it.
namespace stonestack::stacking {

/// Neighbours that count for a stone that no grasp reaches.
enum class Neighbours {
  kAll,     ///< whatever stands beside it
  kLasting  ///< all but the other loose stones, which may be taken first
};
/// A push for the first loose stone that the gripper could hold as it lies, but for what stands beside it;
/// with kAll, where none can be pushed itself, of a loose stone that stands beside one. Nothing if there is
/// none, if no push leads to where a grasp serves, or if enough was pushed already. A push on which the stone
/// may meet the stack where the fingers turn it comes last.
[[nodiscard]] std::optional<Push> push_free(const Situation& situation, const RunMemory& memory,
                                            Neighbours neighbours);
/// A push for a loose stone that leans on the stack, along the stack or away from it.
[[nodiscard]] std::optional<Push> push_off_stack(const Situation& situation, const RunMemory& memory,
                                                 const PlacedStone& stray);

}  // namespace stonestack::stacking
