#pragma once
#include <string>

#include "stonestack/kinematics/robot_model.hpp"

/// Private to kinematics: from a URDF's text to a chain of six joints.
namespace stonestack::kinematics {

/// Parses `text` that came from `path`: name, limits, joint frames and capsules of the chain from base_link
/// to tool0; DH parameters are left alone. Guards before the parser (depth, count of tags) and after it (one
/// root, one parent each, every link reachable, sane limits and inertias). Throws FileError.
[[nodiscard]] RobotModel parse_urdf(const std::string& text, const std::string& path);

}  // namespace stonestack::kinematics
