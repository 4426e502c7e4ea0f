#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/motion/planning_scene.hpp"

#pragma GCC visibility push(default)

namespace stonestack::motion {

/// Options of grasp, transit, approach and placing. Measured in the simulated cell, where no source is named.
struct MotionOptions {
  double speed_scale = 0.5;   ///< of the joint velocity limits
  double acceleration = 1.4;  ///< [rad/s^2]
  double jerk = 0.0;  ///< rad/s^3, of every joint in every motion of a plan; 0: no limit, else 1 or more
  double tool_speed = 1.0;         ///< largest speed of the tool on transits [m/s]
  double near_speed = 0.35;        ///< the same where the tool is near a stone or another object [m/s]
  double near_distance = 0.05;     ///< distance [m] between tool (or what it holds) and object that are near
  double approach = 0.10;          ///< straight approach and retreat [m]
  double descent_speed = 0.005;    ///< guarded [m/s]
  double descent_past = 0.015;     ///< distance [m] past the expected contact where it gives up at the latest
  double transit_padding = 0.010;  ///< [m]
  double approach_padding = 0.002;  ///< [m]
  double approach_speed = 0.10;     ///< speed [m/s] of the tool on straight approaches, lifts and retreats
  double min_threshold = 5.0;       ///< contact at the descent [N]
  double early_threshold = 20.0;    ///< contact while the stone is lowered towards the guarded descent [N]
  double force_noise = 0.15;        ///< one sigma of the force sensor [N]; the threshold is at least six
  bool press_pads = true;           ///< the cost of a grasp includes its firmness by the elastic pad model
  double planning_effort = 5.0;     ///< effort for a whole plan, at most; counted, so no clock decides a plan
  int seed = 1;                     ///< seed of every random draw
};
[[nodiscard]] FieldList fields(MotionOptions& options);

/// One thing to do, in order.
struct PlanStep {
  /// Kind of a step, in the order in which a stone is moved.
  enum class Kind { kOpen, kTransit, kApproach, kGrasp, kLift, kDescent, kRelease, kRetreat };
  Kind kind = Kind::kTransit;  ///< kind of the step
  std::string name;            ///< "move above stone 3"
  JointTrajectory trajectory;  ///< for motions
  double opening = 0.0;  ///< for kOpen (before the gripper goes near the stone) and kRelease [m]: target;
                         ///< for kGrasp: expected between the pads once closed
  double spacing = 0.0;  ///< of fingers B and C, for kOpen [m]
  double finger_speed = 0.0;  ///< for kOpen, kGrasp and kRelease [m/s]
  double force = 0.0;         ///< force a finger [N], for kGrasp
  double threshold = 0.0;     ///< for kDescent and kApproach: force that counts as contact [N]
};

/// Force against the guarded descent (N) that counts as contact for a stone of `mass` kg: the largest of
/// `min_threshold`, six times `force_noise` and 35 % of its weight.
/// @throws InvalidArgument for a mass that is none.
[[nodiscard]] double contact_threshold(double mass, const MotionOptions& options = {});

/// A plan, or why there is none.
struct PickAndPlacePlan {
  /// Outcome of the planning: planned, no grasp serves, out of reach, no transit found, too heavy, or too
  /// wide for the gripper.
  enum class Status { kPlanned, kNoGrasp, kNoReach, kNoTransit, kTooHeavy, kTooWide };
  Status status = Status::kPlanned;  ///< outcome of the planning
  std::string reason;                ///< "of 212 grasps 140 hit the table at pick, ..."
  std::vector<PlanStep> steps;       ///< steps of the plan, in order; empty unless it is planned
  Pose T_O_T = Pose::Identity();     ///< the grasp: tool in the stone's frame
  double spacing = 0.0;              ///< of fingers B and C during it [m]
  double seconds = 0.0;              ///< of motion
  /// Of a plan that failed: grasps T_O_T that were tried and do not bring the stone up from where it lies,
  /// whatever the target: no free straight approach, or no free lift.
  std::vector<Pose> no_pick;
};

/// Where the stone is, where it goes, what the arm does now.
struct PickAndPlaceTask {
  const Stone* stone = nullptr;  ///< stone that is moved; required
  int object = -1;               ///< its index in scene.objects (left out of collision when held); -1: none
  int support = -1;              ///< object that it is to touch at the target; -1: the table
  Pose T_W_O_pick = Pose::Identity();   ///< pose from which the stone is picked
  Pose T_W_O_place = Pose::Identity();  ///< pose in which the stone is placed
  Joints q_start = Joints::Zero();      ///< joint angles at the start [rad]
  std::vector<Pose> avoid;              ///< grasps T_O_T that fail: none near them is taken
  std::vector<Pose> failed_once;  ///< grasps T_O_T that failed before: others near as good are preferred
  std::vector<Pose> no_pick;      ///< the same of grasps that do not bring it up from where it lies now
};
/// Open, transit, approach, grasp, lift, carry, lower, guarded descent, release, retreat: a grasp that serves
/// both ends, free of collision on the whole path, timed within limits. Of several complete plans the
/// quickest. Deterministic for a seed. Throws InvalidArgument for a task that cannot be (no stone, poses that
/// are none).
///
/// The guarded descent ends at contact, not at the planned end: retreat by `plan_retreat` then.
[[nodiscard]] PickAndPlacePlan plan_pick_and_place(const PlanningScene& scene, const PickAndPlaceTask& task,
                                                   const MotionOptions& options = {});

/// Straight back along -z of the tool by `options.approach` from where the arm stands, with the pads
/// `opening` apart; `object` (or -1) is what the gripper has let go of. Empty: out of reach or something in
/// the way.
[[nodiscard]] std::optional<JointTrajectory> plan_retreat(const PlanningScene& scene, const Joints& q,
                                                          double opening, int object,
                                                          const MotionOptions& options = {});

/// A collision-free, timed motion to a joint goal or to a tool pose; empty if there is none.
[[nodiscard]] std::optional<JointTrajectory> plan_transit(const PlanningScene& scene, const Joints& q_start,
                                                          const Joints& q_goal,
                                                          const MotionOptions& options = {});
[[nodiscard]] std::optional<JointTrajectory> plan_transit(const PlanningScene& scene, const Joints& q_start,
                                                          const Pose& T_W_F_goal,
                                                          const MotionOptions& options = {});

/// A grasp so near to one of `failed` (T_O_T) that it would fail as well: 20 mm and 0.35 rad.
[[nodiscard]] bool is_near_grasp(std::span<const Pose> failed, const Pose& T_O_T);

/// Object that the arm overlaps with these joints, where no motion can begin: "at the start the arm stands in
/// something: forearm and wall overlap".
/// @return empty where it stands in nothing.
[[nodiscard]] std::string start_problem(const PlanningScene& scene, const Joints& q_start);

/// Why a task cannot be meant as it stands, at a small part of what planning costs: the arm starts in
/// something, or the stone, where it lies, reaches more than 8 mm into the table or another object, which is
/// more than measured poses err by.
/// @return empty for a task that may be planned.
[[nodiscard]] std::string scene_problem(const PlanningScene& scene, const PickAndPlaceTask& task);

}  // namespace stonestack::motion

#pragma GCC visibility pop
