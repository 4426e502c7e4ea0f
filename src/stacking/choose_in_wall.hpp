#pragma once
#include <optional>

#include "stacking/choose_placement.hpp"

/// Private to stacking/: the next stone of a wall.
namespace stonestack::stacking {

/// The target with joints as wide as the arm needs them, which places a stone to some millimetres.
[[nodiscard]] WallTarget wall_for_arm(WallTarget target);

/// Does a wall stand with all the stones that its target counts?
[[nodiscard]] bool wall_has_its_stones(const Situation& situation);
/// The end of a run whose wall is whole.
[[nodiscard]] Stop wall_stands(const Situation& situation);

/// The next stone of the wall and those that are to follow it, planned for what stands: the rest of the
/// earlier plan if it holds, else another. The friction assumed is one that the stones have with a
/// probability of at least 80 %, and more where less lets no whole wall stand; a stone is reoriented only
/// where no whole wall is found without.
[[nodiscard]] SearchOutcome search_wall(const Situation& situation, const RunMemory& memory);

/// Stones that are expected to stand in the end if the wall goes on from what stands in `problem`, a wall
/// with fewer stones than now; 0 where no more than now are found, and for a task, which more stones do not
/// serve better.
[[nodiscard]] double expected_in_wall(const Situation& situation, const RunMemory& memory,
                                      const SearchProblem& problem, Route route);

/// Figures of the wall as it stands, at the friction that is expected; `memory.wall` is not empty.
[[nodiscard]] WallMetrics measure_wall(const Models& models, const Arrangement& arrangement,
                                       const RunMemory& memory, SearchOptions options);

}  // namespace stonestack::stacking
