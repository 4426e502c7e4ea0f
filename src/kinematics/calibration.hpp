#pragma once
#include <array>
#include <string>

#include "stonestack/core/options.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to kinematics: a robot as measured instead of as drawn.
namespace stonestack::kinematics {

/// A row of a standard DH table: Rz(theta + q) Tz(d) Tx(a) Rx(alpha).
struct DhRow {
  double theta = 0.0, d = 0.0, a = 0.0, alpha = 0.0;  ///< lengths in m, angles in rad
};
/// A joint's frame in its parent's at zero angle, as ROS' ur_calibration writes it.
struct JointOrigin {
  double x = 0.0, y = 0.0, z = 0.0, roll = 0.0, pitch = 0.0, yaw = 0.0;  ///< [rad] and [m]
};

/// Content of a calibration file: numbers that it leaves out stay the robot's own.
struct Calibration {
  std::array<DhRow, 6> dh;
  std::array<JointOrigin, 6> origins;  ///< of the first joint: turned to the base of the DH chain
  std::string hash;                    ///< of ur_calibration; not used
};
[[nodiscard]] Calibration nominal_calibration(const RobotModel& robot);
/// dh.joint_1.theta ..., kinematics.shoulder.x ... (ur_calibration's names).
[[nodiscard]] FieldList fields(Calibration& calibration);

/// Moves the joints' frames to where `measured` has them and derives the DH chain anew. Along its axis, where
/// a joint's frame means nothing, it stays beside the nominal one, so that collision shapes stay in place
/// even where a table has metres along nearly parallel axes. Returns why it cannot be (two tables at once,
/// another robot's), or an empty text.
[[nodiscard]] std::string calibrate(RobotModel& robot, const Calibration& nominal,
                                    const Calibration& measured);

}  // namespace stonestack::kinematics
