#include "simulation/gripper_body.hpp"

#include <algorithm>
#include <limits>

namespace stonestack::simulation {
namespace {

constexpr std::array<double, kFingers> kSide{1.0, -1.0, -1.0};

double finger_y(const GripperModel& gripper, int finger, double narrowed) {
  if (finger == 0) return 0.0;
  return (finger == 1 ? 0.5 : -0.5) * (gripper.finger_spacing - narrowed);
}

}  // namespace

double opening(const GripperPose& gripper_pose) {
  return gripper_pose.finger[0] + 0.5 * (gripper_pose.finger[1] + gripper_pose.finger[2]);
}

GripperBody make_gripper_body(const GripperModel& gripper) {
  GripperBody model{gripper, {}, {}};
  model.pad.width = gripper.finger_width;
  model.pad.length = gripper.pad_length;
  for (const auto& box : gripper.boxes) {
    GripperPart part{box.size, box.p_T_centre, -1, box.spread, box.finger_side, box.camera};
    if (box.finger_side != 0.0) {
      part.finger = box.finger_side > 0 ? 0 : box.p_T_centre.y() > 0 ? 1 : 2;
      part.size.x() -= model.pad.thickness;
      part.p_T_centre.x() += 0.5 * box.finger_side * model.pad.thickness;
    }
    model.boxes.push_back(part);
  }
  return model;
}

Pose box_pose(const GripperPart& box, const GripperPose& gripper_pose) {
  Eigen::Vector3d p_T = box.p_T_centre;
  p_T.y() -= box.spread * gripper_pose.narrowed;
  if (box.finger >= 0) p_T.x() += box.side * gripper_pose.finger[static_cast<std::size_t>(box.finger)];
  return gripper_pose.T_W_T * make_pose(p_T);
}

Pose pad_pose(const GripperBody& model, int finger, const GripperPose& gripper_pose) {
  const auto f = static_cast<std::size_t>(finger);
  Pose T_T_P = Pose::Identity();
  T_T_P.translation() = Eigen::Vector3d(kSide[f] * gripper_pose.finger[f],
                                        finger_y(model.gripper, finger, gripper_pose.narrowed),
                                        -0.5 * model.gripper.pad_length);
  const Eigen::Vector3d z(-kSide[f], 0, 0), x(0, 0, 1);
  T_T_P.linear() << x, z.cross(x), z;
  return gripper_pose.T_W_T * T_T_P;
}

double distance_to_gripper(const GripperBody& model, const GripperPose& gripper_pose,
                           const Eigen::Vector3d& p_W) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& box : model.boxes) {
    const Eigen::Vector3d p = box_pose(box, gripper_pose).inverse() * p_W;
    nearest = std::min(nearest, (p.cwiseAbs() - 0.5 * box.size).cwiseMax(0.0).norm());
  }
  return nearest;
}

Eigen::Vector3d lowest_corner(const GripperBody& model, const GripperPose& gripper_pose) {
  Eigen::Vector3d lowest(0, 0, std::numeric_limits<double>::infinity());
  for (const auto& box : model.boxes) {
    const Pose T_W_box = box_pose(box, gripper_pose);
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
      const Eigen::Vector3d p_W = T_W_box * sign.cwiseProduct(box.size);
      if (p_W.z() < lowest.z()) lowest = p_W;
    }
  }
  return lowest;
}

}  // namespace stonestack::simulation
