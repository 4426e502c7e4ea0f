#pragma once
#include <cstdint>
#include <vector>

#include "detection_scenes.hpp"
#include "rooms.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack::bench {

/// A stone as `run --unseen` would know it, and how its frame lies in that of the scanned stone.
struct StoneFromViews {
  Stone stone;
  Pose T_scan_O = Pose::Identity();
};

/// Models each stone of the maker from four views a resting attitude, without its scan: drawn attitudes, of
/// which the second and further ones are joined with the model where both show enough of the same surface.
/// @param attitudes in which each stone is seen, at least 1
/// @throws InvalidArgument for a stone that is not parted from the table in any of ten attitudes
[[nodiscard]] std::vector<StoneFromViews> stones_from_views(const SceneMaker& maker, int attitudes,
                                                            std::uint64_t seed);

}  // namespace stonestack::bench
