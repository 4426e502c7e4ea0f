#pragma once
#include <string>
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"

namespace urdf {
class Geometry;
}

/// Private to kinematics: collision shapes of a URDF as capsules.
namespace stonestack {

/// The smallest capsule along the longest axis of a sphere, cylinder or box that holds it, in the shape's
/// frame. `link` and `path` are named in messages. Throws FileError, also for a mesh.
[[nodiscard]] LinkCapsule covering(const urdf::Geometry& geometry, const std::string& link,
                                   const std::string& path);

/// Drops what lies in another capsule of its link, and checks what is left: each of the six moving links has
/// a shape, and all together are not more than collision checks take. Throws FileError.
void tidy_shapes(std::vector<LinkCapsule>& capsules, const std::vector<std::string>& moving_links,
                 const std::string& path);

}  // namespace stonestack
