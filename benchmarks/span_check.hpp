#pragma once
#include "rooms.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/search/plan_wall.hpp"

namespace stonestack::bench {

/// Coverage of a span of the x axis by stones, seen by vertical lines every millimetre: without the planner's
/// own figures.
struct SpanCheck {
  double covered = 0.0;     ///< share of the lines through the axis that meet a stone
  double in_the_way = 0.0;  ///< [m] by which the lowest stone in the span lies below what is kept clear
};
/// @param T_V_W frame of the span: x along it, z = 0 the table
[[nodiscard]] SpanCheck check_span(const ShapeList& shapes, const Stack& stones, const Pose& T_V_W,
                                   const Span& span);

/// The stones that touch each other, directly or through others, and the table on both sides of the middle of
/// a span; empty if there are none.
[[nodiscard]] Stack bridging_stones(const ShapeList& shapes, const Stack& stones, const Pose& T_V_W,
                                    const Span& span);

}  // namespace stonestack::bench
