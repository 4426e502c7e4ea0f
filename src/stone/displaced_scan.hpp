#pragma once
#include <cstdint>
#include <vector>

#include "stonestack/stone/stone.hpp"

/// Private to the library: shapes that a stone may have of which not all is known.
namespace stonestack::stone {

/// Scans that agree with what is known of a stone's surface: each vertex displaced along its normal by smooth
/// noise (features of 25 mm) of its standard deviation, but not through a table that the stone lay on, and
/// such that it rests there as it did (within 0.15 rad). The same seed gives the same scans.
/// @return `count` scans in O; fewer where the draws do not rest; none for a stone all of which is known
[[nodiscard]] std::vector<Mesh> displaced_scans(const Stone& stone, int count, std::uint64_t seed);

/// Does a stone of that surface and centre of mass come to rest with about that side up?
[[nodiscard]] bool rests_with(const Mesh& surface_O, const Eigen::Vector3d& p_O_M,
                              const Eigen::Vector3d& up_O, double max_tilt);

}  // namespace stonestack::stone
