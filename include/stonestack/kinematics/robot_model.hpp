#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::kinematics {

/// Six joint angles, rad, in the order base, shoulder, elbow, wrist 1, wrist 2, wrist 3.
using Joints = Eigen::Matrix<double, 6, 1>;

/// Waypoints, joined by straight lines in joint space.
using JointPath = std::vector<Joints>;

/// Joint angles over time: cubic Hermite pieces between knots, so position and velocity are continuous.
struct JointTrajectory {
  std::vector<double> time;  ///< strictly rising, first is 0 [s]
  std::vector<Joints> q;     ///< [rad]
  std::vector<Joints> qd;    ///< [rad/s]

  /// Duration [s] of the trajectory; 0 if it is empty.
  [[nodiscard]] double duration() const { return time.empty() ? 0.0 : time.back(); }
};

/// Why these numbers are no trajectory: lengths that differ, what is not finite, times that do not start at 0
/// and rise. Empty: they are one.
[[nodiscard]] std::string malformed(const JointTrajectory& trajectory);

/// Angles and speeds of all joints.
struct JointState {
  Joints q = Joints::Zero();   ///< joint angles [rad]
  Joints qd = Joints::Zero();  ///< joint speeds [rad/s]
};
/// State at `t`, clamped to the ends.
/// @throws InvalidArgument for an empty trajectory.
[[nodiscard]] JointState sample(const JointTrajectory& trajectory, double t);

struct RobotModel;

/// Allowed positions of the tool's tip: a box along the axes of W.
struct ToolWorkspace {
  Eigen::AlignedBox3d box;        ///< in W [m]
  Pose T_W_R = Pose::Identity();  ///< as calibrated
  Pose T_F_T = Pose::Identity();  ///< as calibrated
};

/// Margin [m] of plans inside the workspace, for rounded corners.
inline constexpr double kWorkspaceMargin = 0.002;

/// Distance [m] of the tip at `q` from the robot's workspace, along the axis where it is largest; negative
/// inside, and where the robot has no workspace.
[[nodiscard]] double outside_workspace(const RobotModel& robot, const Joints& q);
/// "the tool at (0.9, 0, 0.3) m leaves the workspace, ..." where it is further outside than `slack` m, else
/// empty.
[[nodiscard]] std::string describe_outside_workspace(const RobotModel& robot, const Joints& q, double slack);

/// Allowed positions of the whole arm and gripper: a box along the axes of W. Base and shoulder, which stay
/// where they are, count for nothing.
struct ArmFence {
  Eigen::AlignedBox3d box;                   ///< in W [m]
  Pose T_W_R = Pose::Identity();             ///< as calibrated
  std::vector<Eigen::Vector3d> p_F_mounted;  ///< corners of what is mounted on the flange
};
/// "base", "shoulder", "upper arm", ... of link 0 to 6.
[[nodiscard]] const char* link_name(int link);
/// The first link that a fence holds for; 0 and 1 are base and shoulder.
inline constexpr int kFirstFencedLink = 2;
/// Distance [m] by which a link at `q` reaches out of the robot's fence, where it is largest; negative
/// inside, and where the robot has no fence.
[[nodiscard]] double outside_fence(const RobotModel& robot, const Joints& q);
/// "the forearm at (0.9, 0, 0.3) m leaves the fence, ..." where it is further outside than `slack` m, else
/// empty.
[[nodiscard]] std::string describe_outside_fence(const RobotModel& robot, const Joints& q, double slack);

/// A capsule on a link: all points within `radius` of a segment, in the link's frame.
struct LinkCapsule {
  int link =
      0;  ///< 0 base_link, 1 shoulder, 2 upper arm, 3 forearm, 4 wrist 1, 5 wrist 2, 6 wrist 3 (flange)
  Eigen::Vector3d a;    ///< first end of the axis [m], in the link's frame
  Eigen::Vector3d b;    ///< second end of the axis [m], in the link's frame
  double radius = 0.0;  ///< [m]
};

/// A robot with UR kinematics: six revolute joints, spherical-offset wrist. Frames as in its URDF, except
/// that every joint axis is local z. The closed form works on the DH chain that was derived from it:
/// T_R_F(q) = T_R_D * DH(q + dh_offset) * T_D6_F, standard DH with twists 90, 0, 0, 90, -90, 0 degrees.
struct RobotModel {
  std::string name;                    ///< name of the robot: ur10
  double d1 = 0;                       ///< standard DH parameter (data sheet) [m], as the five that follow
  double a2 = 0;                       ///< upper arm [m], negative
  double a3 = 0;                       ///< forearm [m], negative
  double d4 = 0;                       ///< offset along the axis of wrist 1 [m]
  double d5 = 0;                       ///< offset along the axis of wrist 2 [m]
  double d6 = 0;                       ///< offset along the axis of wrist 3 [m]
  Joints lower;                        ///< lower joint limits, within one turn [rad]
  Joints upper;                        ///< upper joint limits, within one turn [rad]
  Joints velocity;                     ///< [rad/s]
  Joints acceleration;                 ///< not in the URDF, 1.4 by default [rad/s^2]
  std::array<Pose, 6> T_parent_joint;  ///< joint frames at zero angle, from the URDF; every axis is local z
  Pose T_6_F = Pose::Identity();       ///< flange (tool0) in link 6
  Pose T_R_D = Pose::Identity();       ///< base of the DH chain (UR: half a turn about z)
  Joints dh_offset = Joints::Zero();   ///< DH angle minus joint angle (UR [rad]: zero)
  Pose T_D6_F = Pose::Identity();      ///< flange in the last DH frame (UR: identity)
  /// The URDF's chain departs from the DH chain by more than 1e-9 (a factory calibration): inverse solutions
  /// are polished on the chain.
  bool calibrated = false;
  std::vector<LinkCapsule> capsules;       ///< collision shape
  double payload = 10.0;                   ///< [kg]
  std::optional<ToolWorkspace> workspace;  ///< where a cell lets the tool go; empty: anywhere
  std::optional<ArmFence> fence;           ///< where a cell lets arm and gripper go; empty: anywhere
  /// Speed [m/s] of the tool's tip that a cell allows. Whatever is timed for the robot keeps it.
  double tool_speed = std::numeric_limits<double>::infinity();
};

/// By name ("ur10", "ur5e", ...: data/robots/NAME.urdf) or by path of a URDF. A file NAME.yaml beside it may
/// give `payload` (kg) and `acceleration` (rad/s^2). Refuses what is not a UR-like chain from `base_link` to
/// `tool0`, and hostile files (loop, two parents, missing limits, depth bomb). Collision shapes are cylinders
/// and spheres (read as capsules), boxes (covered by one) and meshes (by up to six, reported with how far
/// they reach beyond it). A mesh is `package://NAME/PATH`, NAME a folder around the URDF or in
/// ROS_PACKAGE_PATH or AMENT_PREFIX_PATH/share, or a path from the URDF's folder.
/// @throws FileError
[[nodiscard]] RobotModel read_robot(const std::string& name_or_path);
/// Names in data/robots (see data_path), sorted.
/// @throws FileError if there is no such folder.
[[nodiscard]] std::vector<std::string> robot_names();

/// T_R_F of the flange.
[[nodiscard]] Pose forward(const RobotModel& robot, const Joints& q);
/// T_R_link for links 0..6 (0: base).
[[nodiscard]] std::array<Pose, 7> link_poses(const RobotModel& robot, const Joints& q);

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
