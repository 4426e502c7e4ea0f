#pragma once
#include <vector>

#include "report/picture.hpp"
#include "stonestack/motion/planning_scene.hpp"

/// Private to report/: the arm in pictures, and lines.
namespace stonestack::report {

/// A bar of a square section from `p` to `q`.
[[nodiscard]] DrawnMesh drawn_bar(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double width,
                                  const Eigen::Vector3d& colour);

/// Pose of the arm and its gripper.
struct ArmPose {
  Joints q = Joints::Zero();
  double opening = 0.155;  ///< between the finger pads [m]
};

/// Meshes of the links and of the gripper's boxes, in W.
[[nodiscard]] std::vector<DrawnMesh> drawn_arm(const RobotModel& robot, const GripperModel& gripper,
                                               const Pose& T_W_R, const Pose& T_F_T, const ArmPose& pose);

}  // namespace stonestack::report
