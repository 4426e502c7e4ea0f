#pragma once
#include <string>

#include "stonestack/physics/stack.hpp"

#pragma GCC visibility push(default)

namespace stonestack::physics {

/// Why a stone cannot be: mass not positive, inertia not possible, centre of mass outside its hull, nothing
/// finite. Empty if it can.
[[nodiscard]] std::string impossible(const ContactShape& shape);

/// Names two stones of a stack that cut into each other, or one that reaches through the table, by more than
/// `allowed` (m; 8 mm: more than any measurement errs). Empty if there are none.
[[nodiscard]] std::string overlap_of(const ShapeList& shapes, const Stack& stack, double allowed = 0.008);

}  // namespace stonestack::physics

#pragma GCC visibility pop
