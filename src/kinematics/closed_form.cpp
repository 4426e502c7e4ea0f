#include "kinematics/closed_form.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kFreeWrist = 1e-10;  // sine of wrist 2 below which wrist 3 is free

}  // namespace

Target target_of(const RobotModel& robot, const Pose& T_R_F) {
  const Eigen::Matrix3d R_6_F = robot.T_D6_F.linear();
  const Eigen::Matrix3d R_D_R = robot.T_R_D.linear().transpose();
  const Eigen::Matrix3d R_D_F = R_D_R * T_R_F.linear();
  const Eigen::Matrix3d R = R_D_F * R_6_F.transpose();
  const Eigen::Vector3d p_D_F = R_D_R * (T_R_F.translation() - robot.T_R_D.translation());
  Target target{R.col(0), R.col(1), R.col(2), {}};
  target.p_wrist = p_D_F - R * robot.T_D6_F.translation() - robot.d6 * target.z;
  return target;
}

Turn turn_by(double angle) {
  return {angle, std::cos(angle), std::sin(angle)};
}

// The wrist lies d4 beside the arm's plane: r sin(q1 - heading) = d4.
Shoulder solve_shoulder(const RobotModel& robot, const Target& t, double apart) {
  const double r = std::hypot(t.p_wrist.x(), t.p_wrist.y());
  const double side = std::abs(robot.d4);
  Shoulder shoulder;
  double lead = side > r ? 0.5 * kPi : r > 0 ? std::asin(side / r) : 0.0;
  shoulder.miss = side <= r ? 0.0 : side - r;
  lead = std::copysign(std::min(lead, 0.5 * (kPi - apart)), robot.d4);
  const double heading = std::atan2(t.p_wrist.y(), t.p_wrist.x());
  shoulder.q1 = {turn_by(heading + kPi - lead), turn_by(heading + lead)};
  return shoulder;
}

void set_tool(const RobotModel& robot, const Target& t, const Turn& q6, Wrist& wrist) {
  wrist.q6 = q6.angle;
  const Eigen::Vector3d z4 = -(q6.s * t.x + q6.c * t.y);
  const Eigen::Vector3d x5 = q6.c * t.x - q6.s * t.y;
  const Eigen::Vector3d x4 = wrist.q5.c * x5 - wrist.q5.s * t.z;
  const Eigen::Vector3d p = t.p_wrist - robot.d5 * z4;
  wrist.q234 = std::atan2(x4.z(), wrist.q1.c * x4.x() + wrist.q1.s * x4.y());
  wrist.u = wrist.q1.c * p.x() + wrist.q1.s * p.y();
  wrist.v = p.z() - robot.d1;
}

Wrist solve_wrist(const RobotModel& robot, const Target& t, const Turn& q1, bool flipped,
                  double q6_when_free) {
  const Eigen::Vector3d n(q1.s, -q1.c, 0.0);  // axes of shoulder, elbow and wrist 1
  // In the last frame this direction reads (s5 c6, -s5 s6, c5).
  const double nx = n.dot(t.x);
  const double ny = n.dot(t.y);
  const double nz = n.dot(t.z);
  Wrist wrist;
  wrist.q1 = q1;
  wrist.sine = std::sqrt(nx * nx + ny * ny);
  const double s5 = flipped ? -wrist.sine : wrist.sine;
  const double length = std::sqrt(s5 * s5 + nz * nz);
  wrist.q5 = {std::atan2(s5, nz), nz / length, s5 / length};
  if (wrist.sine < kFreeWrist) {
    set_tool(robot, t, turn_by(q6_when_free), wrist);
  } else {
    const double c6 = nx / s5, s6 = -ny / s5;
    set_tool(robot, t, {std::atan2(s6, c6), c6, s6}, wrist);
  }
  return wrist;
}

Elbow solve_elbow(const RobotModel& robot, const Wrist& wrist) {
  const double reach2 = wrist.u * wrist.u + wrist.v * wrist.v;
  const double both = 2.0 * robot.a2 * robot.a3;
  const double cosine = (reach2 - robot.a2 * robot.a2 - robot.a3 * robot.a3) / both;
  if (std::abs(cosine) <= 1.0) {
    const double sine = std::sqrt((1.0 - cosine) * (1.0 + cosine));
    return {{std::atan2(sine, cosine), cosine, sine}, 0.0};
  }
  const double limit = std::abs(cosine > 0 ? robot.a2 + robot.a3 : robot.a2 - robot.a3);
  return {cosine > 0 ? Turn{} : Turn{kPi, -1.0, 0.0}, std::abs(std::sqrt(reach2) - limit)};
}

void turn_into_reach(const RobotModel& robot, const Target& t, Wrist& wrist) {
  const double u5 = wrist.q1.c * t.p_wrist.x() + wrist.q1.s * t.p_wrist.y();
  const double v5 = t.p_wrist.z() - robot.d1;
  const double far = std::hypot(u5, v5);
  const bool outside = wrist.u * wrist.u + wrist.v * wrist.v > robot.a2 * robot.a2 + robot.a3 * robot.a3;
  const double limit = std::abs(outside ? robot.a2 + robot.a3 : robot.a2 - robot.a3);
  const double cosine =
      (limit * limit - far * far - robot.d5 * robot.d5) / (2.0 * std::max(1e-12, far * std::abs(robot.d5)));
  const double half = std::acos(std::clamp(cosine, -1.0, 1.0));
  const double heading = std::atan2(v5, u5);
  const double now = std::atan2(wrist.v - v5, wrist.u - u5);
  const double one = std::remainder(heading + half - now, kTwoPi);
  const double other = std::remainder(heading - half - now, kTwoPi);
  const double turn = std::abs(one) <= std::abs(other) ? one : other;
  if (wrist.sine * std::abs(turn) > kGuess) return;
  set_tool(robot, t, turn_by(wrist.q6 + (wrist.q5.c > 0.0 ? -turn : turn)), wrist);
}

double nearest_turn(double angle, double seed) {
  if (std::abs(angle - seed) <= kPi) return angle;
  return angle - kTwoPi * std::round((angle - seed) / kTwoPi);
}

ArmBend bend_of(const RobotModel& robot, const Wrist& wrist, const Turn& q3) {
  return {std::atan2(wrist.v, wrist.u), std::atan2(robot.a3 * q3.s, robot.a2 + robot.a3 * q3.c), q3.angle};
}

IkSolution solution(const RobotModel& robot, const Wrist& wrist, const ArmBend& bend, int branch,
                    const Joints& seed) {
  const double sign = (branch & 4) == 0 ? 1.0 : -1.0;
  const double q2 = bend.rise - sign * bend.bend, q3 = sign * bend.elbow;
  IkSolution result;
  result.branch = branch;
  result.q << wrist.q1.angle, q2, q3, wrist.q234 - q2 - q3, wrist.q5.angle, wrist.q6;
  result.q -= robot.dh_offset;
  for (int i = 0; i < 6; ++i) result.q[i] = nearest_turn(result.q[i], seed[i]);
  return result;
}

}  // namespace stonestack::kinematics
