#pragma once
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::core {

/// The value that a `share` of `values` (in any order) lies below: 0 the least, 0.5 the median (the upper one
/// of two), 1 the largest. Always one of the values; NaN if there is none. Throws InvalidArgument for a share
/// outside [0, 1].
[[nodiscard]] double quantile(std::vector<double> values, double share);

}  // namespace stonestack::core
