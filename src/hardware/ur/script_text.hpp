#pragma once
#include <string>

#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Values as URScript writes them: always with a decimal point, never with an exponent, never NaN.
namespace stonestack::hardware {

/// Throws InvalidArgument unless |value| is finite and below 1e9.
[[nodiscard]] std::string to_script(double value);
/// "[a, b, c]"
[[nodiscard]] std::string to_script(const Eigen::Vector3d& values);
[[nodiscard]] std::string to_script(const Joints& values);
/// "p[x, y, z, rx, ry, rz]", the rotation as axis times angle.
[[nodiscard]] std::string to_script(const Pose& pose);

}  // namespace stonestack::hardware
