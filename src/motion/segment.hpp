#pragma once
#include <Eigen/Core>

/// Private to motion: exact distances of a line segment, squared, without allocation.
namespace stonestack {

struct Segment {
  Eigen::Vector3d a, b;
};

[[nodiscard]] double squared_distance(const Segment& s, const Eigen::Vector3d& p);
[[nodiscard]] double squared_distance(const Segment& s, const Segment& t);
/// To a solid axis-aligned box; 0 inside.
[[nodiscard]] double squared_distance_to_box(const Segment& s, const Eigen::Vector3d& low,
                                             const Eigen::Vector3d& high);

}  // namespace stonestack
