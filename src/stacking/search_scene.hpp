#pragma once
#include "stonestack/stacking/scene_tasks.hpp"

/// Private to stacking/: from the scene that a user names to a search problem.
namespace stonestack::stacking {

/// Reads and checks the input first, then prepares shapes, and finds the stones if the input is a view.
/// @throws FileError; InvalidArgument; Error (nothing detected, no stable pose).
[[nodiscard]] SearchStart read_start(const SceneSearchTask& input, const Catalogue& catalogue);

}  // namespace stonestack::stacking
