#pragma once
#include <algorithm>

#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {

/// Passes motions on, and notes them.
struct WatchedArm : Arm {
  Arm& arm;
  const RobotModel& robot;
  const Pose T_F_T;
  double fastest = 0.0, fastest_descent = 0.0;  // of the tool's tip [m/s]
  int descents = 0, routes = 0, stops = 0;
  int stopped_at = -1;        // descent that ends by a stop
  int stopped_on_route = -1;  // route, likewise

  WatchedArm(Arm& inner, const RobotModel& model, const Pose& tip) : arm(inner), robot(model), T_F_T(tip) {}
  [[nodiscard]] double tip_speed(const JointTrajectory& trajectory) const {
    constexpr double kStep = 0.02;  // s
    double most = 0.0;
    const auto tip = [&](double t) -> Eigen::Vector3d {
      return (forward(robot, sample(trajectory, t).q) * T_F_T).translation();
    };
    for (double t = kStep; t <= trajectory.duration(); t += kStep)
      most = std::max(most, (tip(t) - tip(t - kStep)).norm() / kStep);
    return most;
  }
  ArmState state() override { return arm.state(); }
  MotionResult follow(const JointTrajectory& trajectory) override {
    fastest = std::max(fastest, tip_speed(trajectory));
    if (routes++ == stopped_on_route)
      return {MotionResult::Status::kStopped, arm.state().q, 0.0, "a person came near"};
    return arm.follow(trajectory);
  }
  MotionResult follow_guarded(const GuardedMotion& motion) override {
    fastest_descent = std::max(fastest_descent, tip_speed(motion.trajectory));
    if (descents++ == stopped_at)
      return {MotionResult::Status::kStopped, arm.state().q, 0.0, "a person came near"};
    return arm.follow_guarded(motion);
  }
  void stop() override {
    ++stops;
    arm.stop();
  }
  void set_payload(double mass, const Eigen::Vector3d& p_F) override { arm.set_payload(mass, p_F); }
};

}  // namespace stonestack::stacking
