#pragma once
#include "core/yaml.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::geometry {

/// A pose {x, y, z, qx, qy, qz, qw}, metres, strictly: nothing missing, nothing more, finite, at most 100 m
/// away, a rotation of length 1. Throws FileError naming file, key and value.
[[nodiscard]] Pose read_pose(yaml::Map map);

}  // namespace stonestack::geometry
