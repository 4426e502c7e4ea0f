#pragma once
#include <array>
#include <optional>
#include <string>

#include "stonestack/core/options.hpp"
#include "stonestack/kinematics/robot_model.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Limits of a cell for its arm, within what the robot can: group `limits` of its file. Lists stand as their
/// text, since they are lists in the file.
struct CellLimits {
  std::string joints;        ///< six of [least, most], degrees; empty: the robot's own
  double joint_speed = 1.0;  ///< share of the robot's own
  double joint_acceleration = 1.0;
  std::array<std::string, 3>
      workspace;  ///< [least, most] of the tool's tip along x, y, z of W, m; empty: no end
};
[[nodiscard]] FieldList fields(CellLimits& limits);

/// The robot as the limits leave it: joint ranges, speeds, accelerations, the room of the tool. Whoever plans
/// with it keeps them, and so does the gate of the arm that it is given to. `path` is named in errors. Throws
/// FileError for numbers that are not finite, ranges that are empty or wider than the robot's.
[[nodiscard]] RobotModel limit_robot(RobotModel robot, const CellLimits& limits, const Pose& T_W_R,
                                     const Pose& T_F_T, const std::string& path);

}  // namespace stonestack::hardware

#pragma GCC visibility pop
