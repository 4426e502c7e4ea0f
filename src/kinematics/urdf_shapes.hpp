#pragma once
#include <string>
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"

namespace urdf {
class Geometry;
}

/// Private to kinematics: collision shapes of a URDF as capsules.
namespace stonestack::kinematics {

/// Capsules that hold a shape, in its frame: the smallest along the longest axis of a sphere, cylinder or
/// box, up to six around a mesh (which is read here and reported with what they add). `link` and `path` are
/// named in messages. Throws FileError.
[[nodiscard]] std::vector<LinkCapsule> covering(const urdf::Geometry& geometry, const std::string& link,
                                                const std::string& path);

/// Drops what lies in another capsule of its link, and checks what is left: each of the six moving links has
/// a shape, and all together are not more than collision checks take. Throws FileError.
void tidy_shapes(std::vector<LinkCapsule>& capsules, const std::vector<std::string>& moving_links,
                 const std::string& path);

}  // namespace stonestack::kinematics
