#include "report/drawn_arm.hpp"

#include <algorithm>

#include "motion/grasp/finger_reach.hpp"
#include "report/link_shapes.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::report {
namespace {

const Eigen::Vector3d kArmColour(0.68, 0.71, 0.75), kLidColour(0.37, 0.56, 0.71),
    kGripperColour(0.24, 0.25, 0.28);

}  // namespace

DrawnMesh drawn_bar(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double width,
                    const Eigen::Vector3d& colour) {
  const double length = std::max((q - p).norm(), 1e-6);
  const Eigen::Vector3d along = (q - p).norm() > 1e-9 ? Eigen::Vector3d((q - p) / (q - p).norm())
                                                      : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  Pose T_W_A = Pose::Identity();
  T_W_A.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along).toRotationMatrix();
  T_W_A.translation() = 0.5 * (p + q);
  return {make_box({width, width, length}), T_W_A, colour};
}

std::vector<DrawnMesh> drawn_arm(const RobotModel& robot, const GripperModel& gripper, const Pose& T_W_R,
                                 const Pose& T_F_T, const ArmPose& pose) {
  const auto links = link_poses(robot, pose.q);
  std::vector<DrawnMesh> meshes;
  for (const LinkShape& shape : link_shapes(robot))
    meshes.push_back({mesh_of(shape), T_W_R * links[static_cast<std::size_t>(shape.link)],
                      shape.lid ? kLidColour : kArmColour});
  const Pose T_W_T = T_W_R * forward(robot, pose.q) * T_F_T;
  for (const GripperBox& box : gripper.boxes) {
    const Eigen::Vector3d centre = box_centre(gripper, box, pose.opening);
    meshes.push_back({make_box(box.size), T_W_T * Pose(Eigen::Translation3d(centre)), kGripperColour});
  }
  return meshes;
}

}  // namespace stonestack::report
