#pragma once
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: whether a stone that is not recognised is gone.
namespace stonestack::stacking {

/// Do views show that a stone is not where it was? They do where they look through the place: where more than
/// a third of what would be seen of it, were it there, is surface behind it. What hides the place from a view
/// says nothing, and no view of it refutes nothing.
/// @param mesh the stone's surface, in O
[[nodiscard]] bool is_refuted(const Views& views, const Mesh& mesh, const Pose& T_W_O);

}  // namespace stonestack::stacking
