#pragma once
#include <optional>
#include <vector>

/// Private to stacking/: friction from the forces on a stone that is dragged over the table.
namespace stonestack::stacking {

/// Coulomb friction from the ratios of force against the drag to force against the table, of readings on the
/// way there (positive) and back (negative): half the difference of their means.
/// @return empty where a direction has no reading, where two of one direction differ by more than 0.25, as
/// they do while a stone sticks or tilts, or where the result is not positive.
[[nodiscard]] std::optional<double> friction_of_drag(const std::vector<double>& there,
                                                     const std::vector<double>& back);

}  // namespace stonestack::stacking
