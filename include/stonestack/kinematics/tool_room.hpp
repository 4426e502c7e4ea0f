#pragma once
#include <Eigen/Geometry>
#include <string>

#include "stonestack/geometry/pose.hpp"
#include "stonestack/kinematics/joints.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

struct RobotModel;

/// Where the tip of the tool may be: a box along the axes of W.
struct ToolRoom {
  Eigen::AlignedBox3d box;        ///< m in W
  Pose T_W_R = Pose::Identity();  ///< as calibrated
  Pose T_F_T = Pose::Identity();  ///< as calibrated
};

/// m that plans stay inside of it, for rounded corners.
inline constexpr double kRoomMargin = 0.002;

/// m by which the tip at `q` is outside the robot's room, along the axis where it is most; negative inside,
/// and where the robot has no room.
[[nodiscard]] double outside_room(const RobotModel& robot, const Joints& q);
/// "the tool at (0.9, 0, 0.3) m leaves the workspace, ..." where it is further outside than `slack` m, else
/// empty.
[[nodiscard]] std::string describe_outside_room(const RobotModel& robot, const Joints& q, double slack);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
