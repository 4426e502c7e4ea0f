#pragma once
#include <span>
#include <string>

#include "stacking/gripper_mass.hpp"
#include "stacking/wrist.hpp"
#include "stonestack/stacking/execute.hpp"

namespace stonestack::stacking {

/// The steps of one plan, carried through one by one, and what to do when one goes otherwise than planned.
struct PlanExecutor {
  const PickAndPlacePlan& plan;
  const Stone& stone;
  const PlanningScene& scene;
  Cell& cell;
  const MotionOptions& options;
  Journal* journal;
  double carried_weight = 0.0;  ///< when the stone was carried last [N]
  Wrist wrist{cell, scene.robot, sensed_gripper_mass(scene.gripper, cell.layout)};

  void intend(const PlanStep& step) const;
  [[nodiscard]] Eigen::Vector3d p_F(const Eigen::Vector3d& p_T) const { return cell.layout.T_F_T * p_T; }
  /// Mass and centre of mass of the hand alone, or with the stone in it.
  void set_payload(bool holding) const;
  [[nodiscard]] ExecutionResult follow(const PlanStep& step) const;
  [[nodiscard]] ExecutionResult grasp(const PlanStep& step) const;
  /// Opens and goes back out, so that the next look starts free.
  [[nodiscard]] ExecutionResult give_up(const PlanStep& step, const std::string& why) const;
  /// Checks by the wrist the stone that hangs in the gripper, against what should hang there: its weight, and
  /// where it pulls.
  [[nodiscard]] ExecutionResult check_hold(const PlanStep& lift) const;
  /// how far from where the stone's centre of mass is in the hand, held as planned, it pulls [m].
  [[nodiscard]] double swing(const WristLoad& load) const;
  [[nodiscard]] static std::string turned(double off);
  /// Before the hand goes nearer to the tower: a stone that is gone is not set down. `lift` is the step that
  /// was followed last before the carry, or null if nothing was lifted.
  [[nodiscard]] ExecutionResult check_carried(const PlanStep* lift, const PlanStep& next);
  /// To where the carry began, the way it came: of all ways that one is known to be free. An empty hand's
  /// fingers open there and not over the tower.
  [[nodiscard]] ExecutionResult go_home(std::span<const PlanStep> carried) const;
  /// Opens where the hand is.
  [[nodiscard]] ExecutionResult release(const std::string& why) const;
  /// Down again the way it was lifted, until it touches; then lets go.
  [[nodiscard]] ExecutionResult put_back(const PlanStep& lift, const std::string& why) const;
  /// W [m].
  [[nodiscard]] Eigen::Vector3d tip(const Joints& q) const;
  /// that the tool stands above where the step would have ended [m].
  [[nodiscard]] double above_end(const PlanStep& step) const;
  /// To a grasp that brings the finger tips nearer to the table than the arm is exact: slowly, and what is
  /// met ends it. Fingers that stand on the table cannot close, so they are lifted a little then.
  [[nodiscard]] ExecutionResult feel_table(const PlanStep& step) const;
  /// Down until the wrist feels something (paper §4.1: impact on the force-torque sensor). `touched` tells
  /// whether it did: above the guarded descent that means a stone that hangs otherwise than planned.
  [[nodiscard]] ExecutionResult feel_down(const PlanStep& step, bool* touched) const;
  void open(const PlanStep& step) const;
  /// Out of the hand's own direction, from where the arm really stands, as far as the plan found room.
  [[nodiscard]] ExecutionResult retreat(const PlanStep& step) const;
  /// Fingers that have opened may still have the stone: stuck, jammed between two, or wedged. What is felt
  /// counts, as a gripper only tells of an object that it closes on. `may_open`: as wide as it goes, once.
  [[nodiscard]] ExecutionResult check_empty(const PlanStep& step, bool may_open) const;
  [[nodiscard]] ExecutionResult clear_table(const PlanStep& step) const;
  [[nodiscard]] ExecutionResult go_back(const PlanStep& step, double distance) const;
};

}  // namespace stonestack::stacking
