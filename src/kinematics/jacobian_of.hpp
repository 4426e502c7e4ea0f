#pragma once
#include <array>

#include "kinematics/jacobian.hpp"

/// Private to kinematics.
namespace stonestack::kinematics {

/// The Jacobian where the links stand as `link_poses` has them and the flange at `p_R_F`.
[[nodiscard]] Jacobian jacobian_of(const std::array<Pose, 7>& T_R_link, const Eigen::Vector3d& p_R_F);

}  // namespace stonestack::kinematics
