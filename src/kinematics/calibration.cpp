#include "kinematics/calibration.hpp"

#include <cmath>
#include <vector>

#include "core/constants.hpp"
#include "kinematics/dh.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kFurthest = 0.05;  // m, a link's origin from the nominal one: more is another robot
constexpr const char* kRosNames[] = {"shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"};

using Links = std::array<Pose, 7>;  ///< base and the six links at zero angles, in R

Pose about_z(double angle) {
  return Pose(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}
/// Returns the transform after the rotation in a row.
Pose beyond(const DhRow& row) {
  return Pose(Eigen::Translation3d(row.a, 0.0, row.d) *
              Eigen::AngleAxisd(row.alpha, Eigen::Vector3d::UnitX()));
}
/// Frames right after the rotation of each joint, at zero angles, in R; the last is that of the flange.
Links rotated_frames(const RobotModel& robot, const std::array<DhRow, 6>& rows) {
  Links frames;
  Pose T = robot.T_R_D;
  for (std::size_t i = 0; i < 6; ++i) {
    frames[i] = T * about_z(rows[i].theta);
    T = frames[i] * beyond(rows[i]);
  }
  frames[6] = T * robot.T_D6_F;
  return frames;
}

Pose pose_of(const JointOrigin& o) {
  return Pose(Eigen::Translation3d(o.x, o.y, o.z) * Eigen::AngleAxisd(o.yaw, Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(o.pitch, Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(o.roll, Eigen::Vector3d::UnitX()));
}
JointOrigin origin_of(const Pose& T) {
  const Eigen::Matrix3d R = T.linear();
  const Eigen::Vector3d p = T.translation();
  return {p.x(),
          p.y(),
          p.z(),
          std::atan2(R(2, 1), R(2, 2)),
          std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
          std::atan2(R(1, 0), R(0, 0))};
}

std::array<double, 24> numbers(const std::array<DhRow, 6>& rows) {
  std::array<double, 24> all{};
  for (std::size_t i = 0; i < 6; ++i) {
    all[4 * i] = rows[i].theta;
    all[4 * i + 1] = rows[i].d;
    all[4 * i + 2] = rows[i].a;
    all[4 * i + 3] = rows[i].alpha;
  }
  return all;
}
std::array<double, 36> numbers(const std::array<JointOrigin, 6>& origins) {
  std::array<double, 36> all{};
  for (std::size_t i = 0; i < 6; ++i) {
    const JointOrigin& o = origins[i];
    const std::array<double, 6> own{o.x, o.y, o.z, o.roll, o.pitch, o.yaw};
    for (std::size_t k = 0; k < 6; ++k) all[6 * i + k] = own[k];
  }
  return all;
}

/// Link frames by the measured rows. Each link keeps its place against the frame of its joint's axis, but for
/// a shift along that axis to beside where it nominally is.
void apply_rows(RobotModel& robot, const Calibration& nominal, const Calibration& measured) {
  const Links drawn = link_poses(robot, Joints::Zero());
  const Links before = rotated_frames(robot, nominal.dh), after = rotated_frames(robot, measured.dh);
  Links links;
  links[0] = Pose::Identity();
  for (std::size_t i = 1; i < 7; ++i) {
    links[i] = after[i - 1] * before[i - 1].inverse() * drawn[i];
    const Eigen::Vector3d n = links[i].linear().col(2);
    links[i].translation() += n * n.dot(drawn[i].translation() - links[i].translation());
  }
  for (std::size_t i = 0; i < 6; ++i) robot.T_parent_joint[i] = links[i].inverse() * links[i + 1];
  robot.T_6_F = links[6].inverse() * after[6];
}

void apply_origins(RobotModel& robot, const Calibration& measured) {
  for (std::size_t i = 0; i < 6; ++i) robot.T_parent_joint[i] = pose_of(measured.origins[i]);
  robot.T_parent_joint[0] = robot.T_R_D * robot.T_parent_joint[0];
}

}  // namespace

Calibration nominal_calibration(const RobotModel& robot) {
  Calibration c;
  const Joints& t = robot.dh_offset;
  c.dh = {DhRow{t[0], robot.d1, 0.0, 0.5 * kPi},  DhRow{t[1], 0.0, robot.a2, 0.0},
          DhRow{t[2], 0.0, robot.a3, 0.0},        DhRow{t[3], robot.d4, 0.0, 0.5 * kPi},
          DhRow{t[4], robot.d5, 0.0, -0.5 * kPi}, DhRow{t[5], robot.d6, 0.0, 0.0}};
  for (std::size_t i = 0; i < 6; ++i)
    c.origins[i] =
        origin_of(i == 0 ? robot.T_R_D.inverse() * robot.T_parent_joint[0] : robot.T_parent_joint[i]);
  return c;
}

FieldList fields(Calibration& c) {
  std::vector<FieldList> lists{{field("kinematics.hash", c.hash, "ur_calibration; not used")}};
  constexpr double kFar = 1000.0;  // m: along nearly parallel axes UR's tables have such
  for (std::size_t i = 0; i < 6; ++i) {
    DhRow& row = c.dh[i];
    JointOrigin& o = c.origins[i];
    lists.push_back(
        nest(concat("dh.joint_", i + 1), {field("theta", row.theta, {-7, 7}, "rad", "controller"),
                                          field("d", row.d, {-kFar, kFar}, "m", "controller"),
                                          field("a", row.a, {-kFar, kFar}, "m", "controller"),
                                          field("alpha", row.alpha, {-7, 7}, "rad", "controller")}));
    lists.push_back(
        nest(concat("kinematics.", kRosNames[i]), {field("x", o.x, {-kFar, kFar}, "m", "ur_calibration"),
                                                   field("y", o.y, {-kFar, kFar}, "m", "ur_calibration"),
                                                   field("z", o.z, {-kFar, kFar}, "m", "ur_calibration"),
                                                   field("roll", o.roll, {-7, 7}, "rad", "ur_calibration"),
                                                   field("pitch", o.pitch, {-7, 7}, "rad", "ur_calibration"),
                                                   field("yaw", o.yaw, {-7, 7}, "rad", "ur_calibration")}));
  }
  return join(std::move(lists));
}

std::string calibrate(RobotModel& robot, const Calibration& nominal, const Calibration& measured) {
  const bool rows = numbers(nominal.dh) != numbers(measured.dh);
  const bool origins = numbers(nominal.origins) != numbers(measured.origins);
  if (!rows && !origins) return {};
  if (rows && origins) return "dh and kinematics both define the joints: keep one of them";
  const Links drawn = link_poses(robot, Joints::Zero());
  const Pose T_R_F = forward(robot, Joints::Zero());
  if (rows)
    apply_rows(robot, nominal, measured);
  else
    apply_origins(robot, measured);
  const Links links = link_poses(robot, Joints::Zero());
  for (std::size_t i = 1; i < 7; ++i)
    if (const double far = (links[i].translation() - drawn[i].translation()).norm(); !(far < kFurthest))
      return concat("joint ", i, " lies ", far, " m from where ", robot.name, " has it: of another robot?");
  if (const double far = (forward(robot, Joints::Zero()).translation() - T_R_F.translation()).norm();
      !(far < kFurthest))
    return concat("the flange lies ", far, " m from where ", robot.name, " has it: of another robot?");
  return derive_dh(robot);
}

}  // namespace stonestack::kinematics
