#pragma once
#include <string>

#include "stonestack/core/rooms.hpp"

/// Private to kinematics: where the meshes lie that a URDF names.
namespace stonestack::kinematics {

/// The file that `uri` stands for: `package://NAME/PATH`, or a path from the folder of `urdf`. A package is
/// sought as a folder NAME that holds the URDF or lies beside one that does, then by ROS_PACKAGE_PATH and in
/// AMENT_PREFIX_PATH/share. Refused are other schemes, absolute paths and `..`: a URDF from elsewhere opens
/// only what lies with it. `link` is named in messages. Throws FileError with the folders that were tried.
[[nodiscard]] std::string find_mesh(const std::string& uri, const std::string& link, const std::string& urdf);

}  // namespace stonestack::kinematics
