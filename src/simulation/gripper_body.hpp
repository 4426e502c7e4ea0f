#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "simulation/finger_drive.hpp"
#include "simulation/finger_pad.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::simulation {

/// The fingers, in the order of every array: A at +x of T, B at -x and +y, C at -x and -y. A gripper with one
/// finger against one has B at y = 0; the third place of an array repeats that of B.
inline constexpr int kFingers = 3;

/// Where the gripper is: tool frame, and how far each finger's pad stands from the plane x = 0 of T.
struct GripperPose {
  Pose T_W_T = Pose::Identity();
  std::array<double, kFingers> finger{};  ///< 0 when closed [m]
  double narrowed = 0.0;                  ///< by which B and C stand closer than the model has them [m]
};
/// The gripper over time, by seconds from the start of a motion.
using GripperPath = std::function<GripperPose(double seconds)>;

/// Distance between the pads: of A from the middle of B and C, m.
[[nodiscard]] double opening(const GripperPose& gripper_pose);

/// A rigid part of the gripper.
struct GripperPart {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_T_centre = Eigen::Vector3d::Zero();  ///< fingers closed
  int finger = -1;                                       ///< moves with that finger; -1: fixed
  double spread = 0.0;                                   ///< along y, of what `narrowed` takes away
  double side = 0.0;                                     ///< along x of T
  bool camera = false;                                   ///< carries the lens
  bool leans =
      false;  ///< turns with the first phalanges: size and centre in their frame, at the palm's joint
};

/// The gripper as the world meets it: rigid boxes, and on each finger a pad of rubber that stands out from
/// the box by its thickness, so that rubber and bone never act twice.
struct GripperBody {
  GripperModel gripper;
  PadOptions pad;
  std::vector<GripperPart> boxes;
  bool phalanges = false;  ///< fingers turn as `finger_linkage`; false: flat jaws, the boxes of `gripper`
  [[nodiscard]] int fingers() const { return 1 + gripper.against; }
};
/// Next places of the fingers after `seconds`, each with a drive of its own; the two of a gripper with one
/// finger against one share a motor, so they move alike and push with the mean of their forces. `force` (N)
/// presses each outwards now.
[[nodiscard]] std::array<double, kFingers> next_finger_places(const GripperBody& model,
                                                              std::array<FingerDriveState, kFingers>& drives,
                                                              const std::array<double, kFingers>& places,
                                                              const std::array<double, kFingers>& force,
                                                              double seconds);

/// The rubber is not the one that plans count on (GripperModel): its own values are in `pad`. Nor is the
/// linkage: `linkage` is "parallel" or "three_finger", whatever the model's; the latter is the arc of its
/// file for another than the 3-finger gripper.
/// @throws InvalidArgument for another name.
[[nodiscard]] GripperBody make_gripper_body(const GripperModel& gripper,
                                            const std::string& linkage = "parallel");

[[nodiscard]] Pose box_pose(const GripperBody& model, const GripperPart& box,
                            const GripperPose& gripper_pose);
/// T_W_P of a finger's pad.
[[nodiscard]] Pose pad_pose(const GripperBody& model, int finger, const GripperPose& gripper_pose);
/// Distance from a point to the nearest box, 0 inside, m.
[[nodiscard]] double distance_to_gripper(const GripperBody& model, const GripperPose& gripper_pose,
                                         const Eigen::Vector3d& p_W);
/// Height of a surface below a point, m in W.
using GroundHeight = std::function<double(const Eigen::Vector3d& p_W)>;
/// The gripper's corner that is lowest over a ground [m in W]; no ground: the plane z = 0.
[[nodiscard]] Eigen::Vector3d lowest_corner(const GripperBody& model, const GripperPose& gripper_pose,
                                            const GroundHeight& ground = {});

}  // namespace stonestack::simulation
