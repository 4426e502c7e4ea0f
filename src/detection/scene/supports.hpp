#pragma once
#include <vector>

#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// Takes planes out of the surface that no model can be part of, as they are longer than `longest` [m]:
/// seats, shelves, walls, tables where the floor is the largest plane. The level ones become supports of the
/// scene. Seeded.
[[nodiscard]] DetectionScene without_large_planes(DetectionScene scene, double longest, int seed);

/// The planes that nothing with its middle at `centre` [m, in C] can reach below: the table, and supports
/// that lie below the middle and whose outlines hold it.
[[nodiscard]] std::vector<Plane> planes_below(const DetectionScene& scene, const Eigen::Vector3d& centre);

}  // namespace stonestack::detection
