#pragma once
#include "stonestack/core/random.hpp"
#include "stonestack/physics/stack.hpp"

/// Private to stacking/: a measured stack that stands in the model as it does in the cell.
namespace stonestack::stacking {

/// A stack that was seen to stand, with poses in which it stands in the model, too, at that friction.
/// Measured poses err by a millimetre, and by that much a stack may slide in the model that stands in truth.
/// If the stack as given stands, it is returned; else `standing_stack` (search/) is asked for one near the
/// given poses, then near poses displaced by what the camera may err. Of those that stand the one nearest to
/// the given, at most 12 mm off at any stone; as given if none stands. Deterministic.
[[nodiscard]] Stack steadied(const ShapeList& shapes, const Stack& seen, double friction);

/// A measured pose moved by what the camera may err: 1 mm along each axis, 0.01 rad, one sigma (ours; the
/// hand-eye error is common to the whole stack and left out).
[[nodiscard]] Pose displaced_as_measured(const Pose& T_W_O, Random& random);

/// How far a pose is from the measured one, m; 0.09 rad count as 6 mm.
[[nodiscard]] double off_measured(const Pose& T_W_O, const Pose& T_W_O_measured);
inline constexpr double kConsistent = 0.006;  ///< m: nearer than that a pose is what was measured, for sure
inline constexpr double kConsistentTurn = 0.09;  ///< rad, the same
inline constexpr double kBelievable = 0.012;     ///< m: the farthest that can be what was measured
inline constexpr double kSettleFrom = 0.002;     ///< m above a measured pose, from where a stone is let down

}  // namespace stonestack::stacking
