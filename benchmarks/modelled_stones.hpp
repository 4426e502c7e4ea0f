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
/// How the stone lies then is sought from the true pose on, where a run knows where it meant to set the stone
/// down.
/// @param attitudes in which each stone is seen, 1 or more; fewer where ten drawn ones give no more to join
/// @throws InvalidArgument for a stone that is not parted from the table in any of ten attitudes
[[nodiscard]] std::vector<StoneFromViews> stones_from_views(const SceneMaker& maker, int attitudes,
                                                            std::uint64_t seed);

}  // namespace stonestack::bench
