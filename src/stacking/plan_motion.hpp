#pragma once
#include "stacking/workcell.hpp"

/// Private to stacking/: the motion that does an action.
namespace stonestack::stacking {

/// Motions of an action, or why there are none.
struct MotionPlan {
  bool found = false;
  std::string refusal;
  Placement placement;  ///< where the stone goes: the candidate, or where it is set down
  Placement followed;   ///< of Reorient: the candidate for which it is set down
  PickAndPlacePlan pick_and_place;
  PlanningScene scene;
  Eigen::Vector3d p_W_aim = Eigen::Vector3d::Zero();  ///< shift of the aim, m
  JointTrajectory route;                              ///< of LookAgain
  std::map<StoneIndex, std::vector<Pose>> no_pick;    ///< T_O_T by stone that were found not to lift it
};

/// Plans the first of the action's candidates that a motion is found for, from where the arm is. Nothing
/// moves.
[[nodiscard]] MotionPlan plan_motion(Workcell& workcell, const WorldEstimate& world, const Action& action,
                                     const RunMemory& memory);
/// Carries it out. Every step is in the journal before it begins.
[[nodiscard]] ExecutionResult execute(Workcell& workcell, const Action& action, const MotionPlan& plan,
                                      std::size_t stack_before, Journal* journal);

}  // namespace stonestack::stacking
