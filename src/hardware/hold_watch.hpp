#pragma once
#include <optional>

#include "stonestack/hardware/devices.hpp"

/// Private to hardware/: notices on the way that the gripper has lost what it carries.
namespace stonestack::hardware {

/// Decides from one answer of the gripper after the other whether what it holds is lost: two answers running
/// in which the fingers are at rest and report no object, or fingers that have closed by more than a stone
/// yields. Fingers that move say nothing else: they close on when a stone yields a little.
class HoldJudge {
 public:
  [[nodiscard]] bool lost(const GripperState& now) {
    const double before = first_opening_.value_or(now.opening);
    first_opening_ = before;
    if (now.object) missing_ = 0;
    if (!now.object && !now.moving) ++missing_;
    return missing_ >= 2 || before - now.opening > kYields;
  }

 private:
  static constexpr double kYields =
      0.010;  // m. Design choice; what is seen of stones that slip is up to 2 mm
  std::optional<double> first_opening_;
  int missing_ = 0;
};

/// An arm whose carries end with a stop once `HoldJudge` says so, from ten answers a second. Only while the
/// arm moves: it may stand because a person paused it, who then takes the object out, and must not be made
/// to move by that. A gripper that does not answer says nothing about what it holds. Everything else is
/// passed on. `arm` and `gripper` must outlive it; during a carry nobody else may use the gripper.
class HoldWatch final : public Arm {
 public:
  HoldWatch(Arm& arm, Gripper& gripper) : arm_(&arm), gripper_(&gripper) {}
  [[nodiscard]] ArmState state() override { return arm_->state(); }
  [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override {
    return arm_->follow(trajectory);
  }
  [[nodiscard]] MotionResult carry(const JointTrajectory& trajectory) override;
  [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override {
    return arm_->follow_guarded(motion);
  }
  void stop() override { arm_->stop(); }
  void set_payload(double mass, const Eigen::Vector3d& p_F_com) override { arm_->set_payload(mass, p_F_com); }

 private:
  Arm* arm_;
  Gripper* gripper_;
};

/// Time between two questions to the gripper [s].
inline constexpr double kHoldPeriod = 0.1;
inline constexpr const char* kDroppedReason = "the gripper reports that it no longer holds anything";

}  // namespace stonestack::hardware
