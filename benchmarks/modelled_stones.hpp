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
  Eigen::Matrix3d R_W_scan = Eigen::Matrix3d::Identity();  ///< the first attitude
};

/// Attitudes and views in which stones are seen.
struct AttitudesSeen {
  std::vector<int> attitudes;  ///< of the first stone, the second and so on; again from the first number
  int views = 4;               ///< of each attitude
  double camera_tilt = 0.8;    ///< of the lowest view off the vertical [rad]
  double min_tilt = 0.0;       ///< of further attitudes against the first [rad]: more for other sides
};

/// Models each stone of the maker from views in a resting attitude, without its scan: drawn attitudes, of
/// which the second and further ones are joined with the model where both show enough of the same surface.
/// How the stone lies then is sought from the true pose on, where a run knows where it meant to set the stone
/// down.
/// Their mass is that of the scan: stones are weighed.
/// There are fewer attitudes than asked for where ten drawn ones give no more to join.
/// @throws InvalidArgument for a stone that is not parted from the table in any of ten attitudes
[[nodiscard]] std::vector<StoneFromViews> stones_from_views(const SceneMaker& maker,
                                                            const AttitudesSeen& seen, std::uint64_t seed);

}  // namespace stonestack::bench
