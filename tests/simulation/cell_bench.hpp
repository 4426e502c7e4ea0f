#pragma once
#include "kinematics/inverse.hpp"
#include "pebble.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {

inline const RobotModel& ur10() {
  static const RobotModel robot = read_robot("ur10");
  return robot;
}

/// Configuration with the tool over a place, pointing down.
inline Joints over(const CellLayout& layout, const Eigen::Vector3d& p_W) {
  const Joints seed = (Joints() << 0.0, -1.57, 1.57, -1.57, -1.57, 0.0).finished();
  return inverse(ur10(), layout.T_W_R.inverse() * tool_down(p_W) * layout.T_F_T.inverse(), seed).front().q;
}

/// Takes every acceleration: the lines of these tests have no regard for it.
inline RobotModel make_agile() {
  RobotModel robot = ur10();
  robot.acceleration.setConstant(1e3);
  return robot;
}

/// A cell with pebbles, and a gripper that moves along straight lines.
struct CellBench {
  std::vector<Stone> stones;
  RobotModel robot = make_agile();
  CellLayout layout;
  SimulatedCell simulated;
  Cell cell;

  explicit CellBench(std::vector<Stone> all, const SimulationOptions& options = {}, const CellLayout& in = {})
      : stones(std::move(all)),
        layout(in),
        simulated(stones, first_stones(stones.size()), robot, layout, options),
        cell(simulated.cell()) {}

  [[nodiscard]] Pose T_W_T(const Joints& q) const { return layout.T_W_R * forward(robot, q) * layout.T_F_T; }

  /// Straight to T_W_T at about `speed`, without regard to acceleration.
  JointTrajectory line(const Pose& T_W_T_goal, double speed) {
    const Joints q0 = cell.arm.state().q;
    const Pose from = T_W_T(q0);
    const auto change = difference(from, T_W_T_goal);
    const double seconds = std::max({0.5, change.translation / speed, change.angle / 0.5});
    const int knots = static_cast<int>(std::ceil(seconds / 0.05)) + 1;
    JointTrajectory line;
    Joints q = q0;
    for (int k = 0; k < knots; ++k) {
      const double s = k / static_cast<double>(knots - 1);
      const Pose T_R_F = layout.T_W_R.inverse() * interpolate(from, T_W_T_goal, s * s * (3 - 2 * s)) *
                         layout.T_F_T.inverse();
      const auto solutions = inverse(robot, T_R_F, q);
      if (solutions.empty()) throw InvalidArgument("the test's line leaves the reach");
      q = k == 0 ? q0 : solutions.front().q;
      line.time.push_back(s * seconds);
      line.q.push_back(q);
    }
    for (int k = 0; k < knots; ++k) {
      const int a = std::max(0, k - 1), b = std::min(knots - 1, k + 1);
      const auto at = [](int i) { return static_cast<std::size_t>(i); };
      line.qd.push_back(k == 0 || k == knots - 1 ? Joints::Zero()
                                                 : Joints((line.q[at(b)] - line.q[at(a)]) /
                                                          (line.time[at(b)] - line.time[at(a)])));
    }
    return line;
  }
  MotionResult go(const Pose& T_W_T_goal, double speed = 0.25) {
    return cell.arm.follow(line(T_W_T_goal, speed));
  }
  /// Goes down to the stone, fingers across its shortest axis, and closes them.
  GripperState grasp(StoneIndex stone) {
    const Eigen::Vector3d p = centre(stone);
    for (const double height : {0.25, std::max(0.004, p.z() - 0.015)})
      if (go(tool_down({p.x(), p.y(), height}, yaw(stone)), height > 0.2 ? 0.25 : 0.1).status !=
          MotionResult::Status::kDone)
        throw InvalidArgument("the arm does not reach the stone");
    return cell.gripper.move(0.0, 0.05, 60.0);
  }
  /// Centre of mass by the catalogue.
  [[nodiscard]] Eigen::Vector3d centre(StoneIndex stone) const {
    const Truth truth = simulated.truth();
    return at(truth.T_W_O, stone) * at(stones, stone).mass.p_O_M;
  }
  [[nodiscard]] double yaw(StoneIndex stone) const {  // closing across the stone's shortest horizontal axis
    const Truth truth = simulated.truth();
    const Eigen::Matrix3d R = at(truth.T_W_O, stone).rotation();
    const Eigen::Vector2d longest = R.col(0).head<2>();
    return std::atan2(longest.y(), longest.x()) + 1.5707963267948966;
  }
};

}  // namespace stonestack::simulation
