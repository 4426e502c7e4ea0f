#include "stonestack/hardware/cell.hpp"

#include "hardware/ready_joints.hpp"
#include "kinematics/gripper_file.hpp"
#include "kinematics/inverse.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kStartHeight = 0.45;  // m, finger tips over the field: the camera's view holds all of it

}  // namespace

Pose CellLayout::make_default_T_T_C() {
  // Beside the palm on the side without fingers. The palm's front edge then lies outside the lower half of
  // the view, and the tilt brings the work, 0.45 m below the finger tips, to the middle of the image.
  constexpr double kTilt = 10.0 * 3.14159265358979323846 / 180.0;
  Pose T_T_C = Pose::Identity();
  T_T_C.translation() = Eigen::Vector3d(0.0, 0.110, -0.170);
  T_T_C.linear() = Eigen::AngleAxisd(kTilt, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T_T_C;
}

CellLayout with_gripper(CellLayout layout, const std::string& name) {
  if (name.empty() || name == layout.gripper) return layout;
  const double longer = read_gripper_file(name).tip - read_gripper_file(layout.gripper).tip;
  layout.T_F_T = layout.T_F_T * Eigen::Translation3d(0, 0, longer);
  layout.T_T_C = Eigen::Translation3d(0, 0, -longer) * layout.T_T_C;
  layout.gripper = name;
  return layout;
}

Joints ready_joints(const RobotModel& robot, const CellLayout& layout) {
  Joints seed;
  seed << 0.0, -1.57, 1.57, -1.57, -1.57, 0.0;
  const Eigen::Matrix3d down =
      Eigen::AngleAxisd(3.14159265358979323846, Eigen::Vector3d::UnitX()).toRotationMatrix();
  for (double share = 1.0; share > 0.3; share -= 0.05) {
    Pose T_W_T = Pose::Identity();
    const Eigen::Vector2d base = layout.T_W_R.translation().head<2>();
    T_W_T.linear() = down;
    T_W_T.translation() << base + share * (layout.field_centre - base), kStartHeight;
    const auto solutions = inverse(robot, layout.T_W_R.inverse() * T_W_T * layout.T_F_T.inverse(), seed);
    if (!solutions.empty()) return solutions.front().q;
  }
  return seed;
}

}  // namespace stonestack::hardware
