#pragma once
#include <string>
#include <vector>

#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stacking/world_estimate.hpp"

/// Private to stacking/: where a measured stack rests. A measured pose errs by a millimetre: the stone floats
/// or sinks by that, and a stack may slide in the model that stands in truth.
namespace stonestack::stacking {

/// A stone of a stack as it was measured.
struct MeasuredStone {
  StoneEstimate estimate;
  bool moved = true;  ///< measured anew; false: `T_W_O_at_rest` is known from before
};

/// The only settling of a measured stack. First each stone that was measured anew is let down on those below
/// it from 2 mm above. Then the whole stack is judged at `friction`: if it stands as it is, it is returned;
/// else `settled_stack` (search/) is asked for one near the given poses, then near poses displaced by what
/// the camera may err. Of those that stand the nearest to the measured one is taken, at most 12 mm off at any
/// stone; the measured one if none stands. `T_W_O_seen` is kept. Deterministic.
/// @param tower each stone rests on the one before it alone; false: a wall
[[nodiscard]] std::vector<StoneEstimate> settle_stack(const ShapeList& shapes,
                                                      const std::vector<MeasuredStone>& stack,
                                                      double friction, bool tower = true);

/// A settled stack at each of some frictions. `options` set how stacks are judged.
[[nodiscard]] std::vector<RestingStack> resting_stacks(const ShapeList& shapes, const Stack& stack,
                                                       const SearchOptions& options,
                                                       const std::vector<double>& frictions,
                                                       bool tower = true);

/// Does the stack stand at any of the frictions?
[[nodiscard]] bool stands_at_some_friction(const std::vector<RestingStack>& resting);

/// Distance of a pose from the measured one, m; 0.09 rad count as 6 mm.
[[nodiscard]] double off_measured(const Pose& T_W_O, const Pose& T_W_O_measured);
inline constexpr double kConsistent = 0.006;  ///< distance up to which a pose is the measured one for sure, m
inline constexpr double kConsistentTurn = 0.09;  ///< angle likewise, rad
inline constexpr double kMaxMeasured = 0.012;  ///< largest distance of a pose that can be the measured one, m

}  // namespace stonestack::stacking
