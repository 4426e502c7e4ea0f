#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack {

/// Options of grasp, transit, approach and placing. Sources: facts/robot.md.
struct MotionOptions {
  double speed_scale = 0.5;         ///< of the joint velocity limits
  double acceleration = 1.4;        ///< rad/s^2
  double approach = 0.10;           ///< m, straight approach and retreat
  double lift = 0.10;               ///< m
  double descent_speed = 0.005;     ///< m/s, guarded
  double descent_length = 0.020;    ///< m above the expected contact where the guarded part starts
  double descent_past = 0.015;      ///< m past the expected contact where it gives up
  double transit_padding = 0.010;   ///< m
  double approach_padding = 0.002;  ///< m
  double planning_seconds = 5.0;    ///< transit, at most
  int seed = 1;
};
[[nodiscard]] FieldList fields(MotionOptions& options);

/// One thing to do, in order.
struct PlanStep {
  enum class Kind { kOpen, kTransit, kApproach, kGrasp, kLift, kDescent, kRelease, kRetreat };
  Kind kind = Kind::kTransit;
  std::string name;            ///< "move above stone 3"
  JointTrajectory trajectory;  ///< for motions
  double opening = 0.0;        ///< m, for kOpen (before the hand goes near the stone) and kRelease: target;
                               ///< for kGrasp: expected between the pads once closed
  double finger_speed = 0.0;   ///< m/s, for kOpen, kGrasp and kRelease
  double force = 0.0;          ///< N a finger, for kGrasp
  double threshold = 0.0;      ///< N, for kDescent
};

/// A plan, or why there is none.
struct PickAndPlacePlan {
  enum class Status { kPlanned, kNoGrasp, kNoReach, kNoTransit, kTooHeavy, kTooWide };
  Status status = Status::kPlanned;
  std::string reason;  ///< "of 212 grasps 140 hit the table at pick, ..."
  std::vector<PlanStep> steps;
  Pose T_O_T = Pose::Identity();  ///< the grasp: tool in the stone's frame
  double seconds = 0.0;           ///< of motion
};

/// Where the stone is, where it goes, what the arm does now.
struct PickAndPlaceTask {
  const Stone* stone = nullptr;
  int object = -1;   ///< its index in scene.objects (left out of collision when held); -1: none
  int support = -1;  ///< object that it is to touch at the target; -1: the table
  Pose T_W_O_pick = Pose::Identity();
  Pose T_W_O_place = Pose::Identity();
  Joints q_start = Joints::Zero();
};
/// A grasp that serves both pick and place, collision-free transit (OMPL), straight approach, lift, guarded
/// descent and retreat, timed within limits. Deterministic for a seed.
[[nodiscard]] PickAndPlacePlan plan_pick_and_place(const PlanningScene& scene, const PickAndPlaceTask& task,
                                                   const MotionOptions& options = {});

/// A collision-free, timed motion to a joint goal or to a tool pose; empty if there is none.
[[nodiscard]] std::optional<JointTrajectory> plan_transit(const PlanningScene& scene, const Joints& q_start,
                                                          const Joints& q_goal,
                                                          const MotionOptions& options = {});
[[nodiscard]] std::optional<JointTrajectory> plan_transit(const PlanningScene& scene, const Joints& q_start,
                                                          const Pose& T_W_F_goal,
                                                          const MotionOptions& options = {});

}  // namespace stonestack
