#pragma once
#include "stonestack/motion/pick_and_place.hpp"

/// Motions that push a loose stone over the table with the closed gripper.
namespace stonestack::motion {

/// A loose stone to push, and where the arm is.
struct PushTask {
  const Stone* stone = nullptr;                         ///< required
  int object = -1;                                      ///< its index in scene.objects; -1: none
  Pose T_W_O = Pose::Identity();                        ///< as it lies
  Eigen::Vector2d p_W_shift = Eigen::Vector2d::Zero();  ///< how far it is to move over the table [m]
  Joints q_start = Joints::Zero();                      ///< joint angles at the start [rad]
};

/// Close, transit, guarded way down behind the stone, guarded way up to it (kDescent), guarded push
/// (kDescent), retreat back and up, open. It goes down 8 mm behind the stone where there is room, and the way
/// up to it is 25 mm long where that is free: who carries it out stops where the stone is felt, and pushes
/// and retreats from there by the lengths of these steps. The gripper points straight down, its fingers drawn
/// together where they can be, and the line of the push goes through the stone's centre of mass, so that the
/// stone turns little, or passes it by 15 mm where there is no room for that. All of it is free of collision
/// with everything but the stone. Which things the stone itself meets on its way the caller has to know.
/// @throws InvalidArgument for a task that cannot be: no stone, no shift, numbers that are not finite.
[[nodiscard]] PickAndPlacePlan plan_push(const PlanningScene& scene, const PushTask& task,
                                         const MotionOptions& options = {});

}  // namespace stonestack::motion
