#include "kinematics/dh.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {
namespace {

// A factory calibration stays well within these; another kind of robot does not.
constexpr double kAngleTolerance = 0.02;  // rad
constexpr double kGapTolerance = 0.01;    // m
constexpr const char* kNames[] = {"base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3"};

/// The axis of a joint in R, at zero angles.
struct Axis {
  Eigen::Vector3d p;
  Eigen::Vector3d n;
};

std::array<Axis, 6> axes_at_zero(const RobotModel& robot) {
  const auto poses = link_poses(robot, Joints::Zero());
  std::array<Axis, 6> axes;
  for (std::size_t i = 0; i < 6; ++i) axes[i] = {poses[i + 1].translation(), poses[i + 1].linear().col(2)};
  return axes;
}

/// The point of `a` nearest to `b`; the axes must not be parallel.
Eigen::Vector3d nearest_point(const Axis& a, const Axis& b) {
  const Eigen::Vector3d across = a.n.cross(b.n);
  const double t = (b.p - a.p).cross(b.n).dot(across) / across.squaredNorm();
  return a.p + t * a.n;
}

double gap(const Axis& a, const Axis& b) {
  return std::abs((b.p - a.p).dot(a.n.cross(b.n).normalized()));
}

/// Where the axis crosses the plane through `p` with normal `n`.
Eigen::Vector3d crossing(const Axis& axis, const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  return axis.p + axis.n * ((p - axis.p).dot(n) / axis.n.dot(n));
}

/// Angle from `a` to `b` about `n`.
double turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& n) {
  return std::atan2(a.cross(b).dot(n), a.dot(b));
}

std::string ur_mismatch(const std::array<Axis, 6>& axes) {
  const auto angle = [&](std::size_t i, std::size_t j) {
    return std::acos(std::clamp(axes[i].n.dot(axes[j].n), -1.0, 1.0));
  };
  for (const auto& [i, j] : {std::pair<std::size_t, std::size_t>{1, 2}, {2, 3}})
    if (angle(i, j) > kAngleTolerance)
      return concat("axes of ", kNames[i], " and ", kNames[j], " are ", angle(i, j) * 180.0 / kPi,
                    " deg apart, a UR's are parallel");
  for (const auto& [i, j] : {std::pair<std::size_t, std::size_t>{0, 1}, {3, 4}, {4, 5}}) {
    if (std::abs(angle(i, j) - 0.5 * kPi) > kAngleTolerance)
      return concat("axes of ", kNames[i], " and ", kNames[j], " are ", angle(i, j) * 180.0 / kPi,
                    " deg apart, a UR's are at right angles");
    if (gap(axes[i], axes[j]) > kGapTolerance)
      return concat("axes of ", kNames[i], " and ", kNames[j], " pass at ", gap(axes[i], axes[j]),
                    " m, a UR's meet");
  }
  return {};
}

Pose dh_step(double theta, double d, double a, double alpha) {
  Pose T = Pose::Identity();
  T.linear() = (Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(alpha, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = Eigen::Vector3d(a * std::cos(theta), a * std::sin(theta), d);
  return T;
}

/// Sixth DH frame in the first.
Pose dh_chain(const RobotModel& robot, const Joints& q) {
  const Joints t = q + robot.dh_offset;
  return dh_step(t[0], robot.d1, 0.0, 0.5 * kPi) * dh_step(t[1], 0.0, robot.a2, 0.0) *
         dh_step(t[2], 0.0, robot.a3, 0.0) * dh_step(t[3], robot.d4, 0.0, 0.5 * kPi) *
         dh_step(t[4], robot.d5, 0.0, -0.5 * kPi) * dh_step(t[5], robot.d6, 0.0, 0.0);
}

/// Largest departure of the DH chain from the URDF's, over configurations that move every joint.
double departure(const RobotModel& robot) {
  double worst = 0.0;
  for (int k = 0; k < 12; ++k) {
    Joints q;
    for (int i = 0; i < 6; ++i) q[i] = 1.1 * std::sin(1.0 + 2.3 * k + 1.7 * i);
    const Pose exact = forward(robot, q);
    const Pose dh = forward_dh(robot, q);
    worst = std::max(worst, (exact.matrix() - dh.matrix()).cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

Pose forward_dh(const RobotModel& robot, const Joints& q) {
  return robot.T_R_D * dh_chain(robot, q) * robot.T_D6_F;
}

std::string derive_dh(RobotModel& robot) {
  const auto axes = axes_at_zero(robot);
  if (const auto reason = ur_mismatch(axes); !reason.empty()) return reason;

  // The arm's plane: through the shoulder's centre, across the three parallel axes.
  const Eigen::Vector3d n = axes[1].n;
  const Eigen::Vector3d p_shoulder = nearest_point(axes[0], axes[1]);
  const Eigen::Vector3d p_elbow = crossing(axes[2], p_shoulder, n);
  const Eigen::Vector3d p_wrist = crossing(axes[3], p_shoulder, n);
  robot.a2 = -(p_elbow - p_shoulder).norm();  // UR's tables have both lengths negative
  robot.a3 = -(p_wrist - p_elbow).norm();
  if (-robot.a2 < kGapTolerance || -robot.a3 < kGapTolerance)
    return concat("upper arm and forearm have lengths ", -robot.a2, " and ", -robot.a3, " m");

  // x axes of the DH frames at zero joint angles, by their definitions (twists 90, 0, 0, 90, -90, 0).
  const Eigen::Vector3d z0 = axes[0].n;
  const Eigen::Vector3d x1 = z0.cross(n).normalized();
  const Eigen::Vector3d x2 = (p_shoulder - p_elbow).normalized();
  const Eigen::Vector3d x3 = (p_elbow - p_wrist).normalized();
  const Eigen::Vector3d x4 = axes[3].n.cross(axes[4].n).normalized();
  const Eigen::Vector3d x5 = axes[5].n.cross(axes[4].n).normalized();
  robot.dh_offset << 0.0, turn(x1, x2, n), turn(x2, x3, n), turn(x3, x4, n), turn(x4, x5, axes[4].n), 0.0;

  const Eigen::Vector3d p_base = axes[0].p - z0 * z0.dot(axes[0].p);
  robot.T_R_D.linear() << x1, z0.cross(x1), z0;
  robot.T_R_D.translation() = p_base;
  robot.d1 = (p_shoulder - p_base).dot(z0);
  const Eigen::Vector3d p_wrist_2 = nearest_point(axes[3], axes[4]);
  const Eigen::Vector3d p_wrist_3 = nearest_point(axes[4], axes[5]);
  const Pose T_R_F = forward(robot, Joints::Zero());
  robot.d4 = (p_wrist_2 - p_shoulder).dot(n);
  robot.d5 = (p_wrist_3 - nearest_point(axes[4], axes[3])).dot(axes[4].n);
  robot.d6 = (T_R_F.translation() - nearest_point(axes[5], axes[4])).dot(axes[5].n);
  robot.T_D6_F = (robot.T_R_D * dh_chain(robot, Joints::Zero())).inverse() * T_R_F;

  const double worst = departure(robot);
  robot.calibrated = worst > 1e-9;
  if (worst > 0.1) return concat("its closest UR geometry is off by ", worst, " m");
  return {};
}

}  // namespace stonestack::kinematics
