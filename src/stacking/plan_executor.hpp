#pragma once
#include <span>
#include <string>

#include "stacking/execute.hpp"
#include "stacking/gripper_mass.hpp"
#include "stacking/wrist.hpp"

namespace stonestack::stacking {

/// Executes the steps of one plan one by one, and reacts when one does not go as planned.
struct PlanExecutor {
  const PickAndPlacePlan& plan;
  const Stone& stone;
  const PlanningScene& scene;
  Cell& cell;
  const MotionOptions& options;
  Journal* journal;
  bool weighs = false;            ///< the stone's mass is a guess until it is lifted
  double mass = stone.mass.mass;  ///< of the stone [kg]
  double carried_weight = 0.0;    ///< measured when the stone was carried last [N]
  Wrist wrist{cell, scene.robot, sensed_gripper_mass(scene.gripper, cell.layout)};

  void intend(const PlanStep& step) const;
  [[nodiscard]] Eigen::Vector3d p_F(const Eigen::Vector3d& p_T) const { return cell.layout.T_F_T * p_T; }
  /// Mass and centre of mass of the gripper alone, or with the stone in it.
  [[nodiscard]] GripperMass load(bool holding) const;
  void set_payload(bool holding) const;
  /// Tells the arm what it carries with the stone.
  /// @return why it refuses that: too heavy; empty: it does not. An arm that does not answer ends the run
  [[nodiscard]] std::string take_payload() const;
  [[nodiscard]] ExecutionResult follow(const PlanStep& step) const;
  /// Follows a step with the stone in the gripper. A stone that is lost on the way stops the arm there; it
  /// goes back along its way to the end of `lift`, where what is left in the gripper is let go of or put
  /// back.
  [[nodiscard]] ExecutionResult carry(const PlanStep& lift, const PlanStep& step) const;
  /// Lifts to where the plan does, straight from where the arm stands: fingers that felt the table went back
  /// from where the plan grasps.
  [[nodiscard]] ExecutionResult lift(const PlanStep& step) const;
  [[nodiscard]] ExecutionResult grasp(const PlanStep& step) const;
  /// Opens and retreats, so that the next view starts free.
  [[nodiscard]] ExecutionResult give_up(const PlanStep& step, const std::string& why) const;
  /// Compares the load on the wrist with that of the planned stone: its weight, and its line of action. A
  /// mass that is a guess becomes the measured one.
  [[nodiscard]] ExecutionResult check_hold(const PlanStep& lift);
  /// Distance of the load's line of action from the stone's centre of mass as planned [m].
  [[nodiscard]] double swing(const WristLoad& load) const;
  [[nodiscard]] static std::string turned(double off);
  /// Before the gripper goes nearer to the tower: a stone that is gone is not set down. `lift` is the step
  /// that was followed last before the carry, or null if nothing was lifted. `lowering`, where it is given,
  /// is the step that ends here: a stone that weighs less after it, but not when it is raised again, has
  /// touched something. It stays raised then, and `rests` becomes true.
  [[nodiscard]] ExecutionResult check_carried(const PlanStep* lift, const PlanStep& next,
                                              const PlanStep* lowering = nullptr, bool* rests = nullptr);
  /// Returns to where the carry began along the same path, which is known to be free. An empty gripper
  /// opens there and not over the tower.
  [[nodiscard]] ExecutionResult go_home(std::span<const PlanStep> carried) const;
  /// Opens where the gripper is.
  [[nodiscard]] ExecutionResult release(const std::string& why) const;
  /// Lowers the stone along the path on which it was lifted, until contact; then releases it.
  [[nodiscard]] ExecutionResult put_back(const PlanStep& lift, const std::string& why) const;
  /// W [m].
  [[nodiscard]] Eigen::Vector3d tip(const Joints& q) const;
  /// Height of the tool above the planned end of the step [m].
  [[nodiscard]] double above_end(const PlanStep& step) const;
  /// Opening with the stone between the pads, as planned [m]; 0 for a plan without a grasp.
  [[nodiscard]] double held_opening() const;
  /// Distance by which the finger tips come further out while they close on the stone [m].
  [[nodiscard]] double closing_advance() const;
  /// Approaches a grasp until contact. Fingers pressed on the table cannot close, so they are lifted a little
  /// then. Contact further above means that a finger stands on a stone: not where the plan takes it to be.
  /// Then the gripper goes back, and nothing is picked.
  [[nodiscard]] ExecutionResult approach_grasp(const PlanStep& step) const;
  /// Lowers until the wrist measures contact (paper §4.1: impact on the force-torque sensor). `touched` is
  /// true for contact: above the guarded descent it means a stone that is held otherwise than planned.
  [[nodiscard]] ExecutionResult feel_down(const PlanStep& step, bool* touched) const;
  /// Lowers in the same way from where the arm stands to the end of the step.
  [[nodiscard]] ExecutionResult feel_down_from_here(const PlanStep& step, bool* touched) const;
  /// Drags the stone, which rests on the table and is still held, there and back, and compares the forces
  /// along and against the table. The result has no friction where the stone does not press or does not
  /// slide.
  [[nodiscard]] ExecutionResult measure_friction() const;
  void open(const PlanStep& step) const;
  /// Distance of the planned retreat [m].
  [[nodiscard]] double retreat_length(const PlanStep& step) const;
  /// Retreats along the gripper's own axis from the arm's measured pose, as far as the plan found clearance.
  [[nodiscard]] ExecutionResult retreat(const PlanStep& step) const;
  /// Does the gripper report an object that its fingers may hold? Fingers that stand fully open press on
  /// none, whatever it reports.
  [[nodiscard]] bool reports_object_between() const;
  /// Checks that opened fingers hold no stone: stuck, jammed between two, or wedged. The measured load
  /// decides, as a gripper only reports an object that it closes on. `may_open`: may open fully, once.
  [[nodiscard]] ExecutionResult check_empty(const PlanStep& step, bool may_open) const;
  /// Checks that the fingers are empty once they have left. A stone that hangs on them is set down where it
  /// came from, once, and left with the fingers fully open. `over_table`: nothing but the table is below;
  /// then fingers that a stone fell onto are drawn out from beneath it.
  [[nodiscard]] ExecutionResult leave_empty(const PlanStep& step, bool over_table) const;
  /// Retreats further, in parts, as far as nothing else is in the way, until the wrist bears nothing: the
  /// table holds the stone back, which bears most of it. `not_empty` is the result where that does not help.
  [[nodiscard]] ExecutionResult draw_out(const PlanStep& step, const ExecutionResult& not_empty) const;
  /// Height above the table of the lowest place of the fingers at an opening [m]: those of an inclined
  /// gripper go down as it opens.
  [[nodiscard]] double lowest_finger(double opening) const;
  /// Opens fully, unless the gripper is so inclined that a finger would reach the table.
  [[nodiscard]] ExecutionResult open_wide(const PlanStep& step) const;
  [[nodiscard]] ExecutionResult clear_table(const PlanStep& step, double opening) const;
  /// Goes back until fingers that have closed on nothing can open: those of an inclined gripper sweep down.
  [[nodiscard]] ExecutionResult clear_table_empty(const PlanStep& step, double opening) const;
  [[nodiscard]] ExecutionResult go_back(const PlanStep& step, double distance) const;
  /// Moves the closed gripper straight on as far as the step does, from where the arm stands, until more
  /// resists than the step's threshold; `resisted` is true then.
  [[nodiscard]] ExecutionResult push(const PlanStep& step, bool* resisted) const;
  /// Follows a straight step, or that share of it, from where the arm stands: as far, and in the same
  /// direction.
  [[nodiscard]] ExecutionResult follow_from_here(const PlanStep& step, double share = 1.0) const;
  /// From the arm's measured pose straight to where a straight step began, which it broke off.
  [[nodiscard]] ExecutionResult back_to_start(const PlanStep& step) const;
  /// From the arm's measured pose straight and slowly to where these joints have the tool.
  [[nodiscard]] ExecutionResult straight_to(const PlanStep& step, const Joints& q_end) const;
  /// The straight path of a straight step, displaced to where the arm stands; empty where the arm cannot
  /// follow it.
  [[nodiscard]] std::optional<JointPath> path_from_here(const PlanStep& step, double share = 1.0) const;
  /// Follows a straight path slowly.
  [[nodiscard]] ExecutionResult follow_slowly(const PlanStep& step, const JointPath& path) const;
  /// A path with times, the tool never faster than `tool_speed` m/s.
  [[nodiscard]] JointTrajectory timed(const JointPath& path, double tool_speed) const;
};

}  // namespace stonestack::stacking
