#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "hardware/guard_readings.hpp"
#include "hardware/hold_watch.hpp"
#include "hardware/trajectory_gate.hpp"
#include "kinematics/inverse.hpp"
#include "kinematics/jacobian.hpp"
#include "simulation/simulated_devices.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kArmTick = 0.010;        // s, control and force samples
constexpr double kControlPeriod = 0.008;  // s, at which the gate looks at a path. CB3
constexpr int kFirstLink = 2;             // links below the upper arm stand on the table
constexpr int kTicksPerCheck = 5;         // links are compared with table and stones every 50 ms
constexpr int kTicksPerHold = 10;         // ticks of a carry between questions to the gripper
constexpr double kStopTime = 0.2;         // s from full speed to rest once it has lost the stone
constexpr int kStartSamples = 10;         // whose mean is a guarded motion's start value
constexpr double kLinkShift = 0.0003;  // m, one sigma and axis: ratio of the two errors of a link, which are
constexpr double kLinkTurn = 0.0005;   // rad     scaled together; of the size of factory calibrations
constexpr double kLowest = 0.05, kHighest = 0.35;  // m, of tips over the table where links are measured
/// Torque limits of a UR10's joints, Nm (data sheet): the gears are as stiff in proportion.
const Joints kGearSize = (Joints() << 330.0, 330.0, 150.0, 56.0, 56.0, 56.0).finished();

double distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double s = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (p - a - s * ab).norm();
}

double smooth(double s) {
  return s * s * (3 - 2 * s);
}

}  // namespace

double joint_sigma(double tip_error, const RobotModel& robot, const Pose& T_F_T, const Joints& q) {
  const Eigen::Vector3d p_R_FT = forward(robot, q).linear() * T_F_T.translation();
  const Jacobian J = jacobian(robot, q);
  double squares = 0.0;
  for (Eigen::Index j = 0; j < 6; ++j) {
    const Eigen::Vector3d v = J.col(j).head<3>(), w = J.col(j).tail<3>();
    squares += (v + w.cross(p_R_FT)).squaredNorm();
  }
  return tip_error / std::sqrt(squares);
}

namespace {

/// Reported joints over field and site, fingers down, at two heights: where links are measured.
std::vector<Joints> joints_over_cell(const CellLayout& layout, const RobotModel& robot, const Joints& seed) {
  const Eigen::Matrix3d down = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  std::vector<Eigen::Vector2d> places{layout.site, layout.field_centre};
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      places.emplace_back(layout.field_centre + layout.field_size.cwiseProduct(Eigen::Vector2d(x, y)));
  std::vector<Joints> found;
  for (const auto& place : places)
    for (const double z : {kLowest, kHighest}) {
      const Pose T_W_T = make_pose(Eigen::Vector3d(place.x(), place.y(), z), Eigen::Quaterniond(down));
      const auto solutions = inverse(robot, layout.T_W_R.inverse() * T_W_T * layout.T_F_T.inverse(), seed);
      if (!solutions.empty()) found.push_back(solutions.front().q);
    }
  if (found.empty()) found.push_back(seed);
  return found;
}

Pose small_motion(const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  return make_pose(shift, angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle))
                                    : Eigen::Quaterniond::Identity());
}

/// The robot with every link a little other than its model, by `factor` times the drawn errors.
RobotModel with_link_errors(const RobotModel& robot, const std::array<Eigen::Vector3d, 14>& drawn,
                            double factor) {
  RobotModel real = robot;
  const auto error = [&](std::size_t i) {
    return small_motion(factor * drawn[2 * i], factor * drawn[2 * i + 1]);
  };
  for (std::size_t i = 0; i < real.T_parent_joint.size(); ++i)
    real.T_parent_joint[i] = real.T_parent_joint[i] * error(i);
  real.T_6_F = real.T_6_F * error(6);
  real.calibrated = true;
  return real;
}

/// Draws the errors of all links so that the tip is off by `tip_error` (root of the mean square) over the
/// cell.
RobotModel draw_links(const CellLayout& layout, double tip_error, const RobotModel& robot, const Joints& q,
                      Random random) {
  std::array<Eigen::Vector3d, 14> drawn;
  for (std::size_t i = 0; i < drawn.size(); ++i)
    for (double& value : drawn[i]) value = random.normal(0.0, i % 2 == 0 ? kLinkShift : kLinkTurn);
  const auto poses = joints_over_cell(layout, robot, q);
  const RobotModel unscaled = with_link_errors(robot, drawn, 1.0);
  double squares = 0.0;
  for (const Joints& at : poses)
    squares += ((forward(unscaled, at) * layout.T_F_T).translation() -
                (forward(robot, at) * layout.T_F_T).translation())
                   .squaredNorm();
  return with_link_errors(robot, drawn, tip_error / std::sqrt(squares / static_cast<double>(poses.size())));
}

/// Linear motion of the tool's tip and turn of the tool by each joint, axes of W.
Jacobian tip_jacobian(const RobotModel& robot, const Pose& T_W_R, const Pose& T_F_T, const Joints& q) {
  const Eigen::Vector3d p_R_FT = forward(robot, q).linear() * T_F_T.translation();
  Jacobian J = jacobian(robot, q);
  for (Eigen::Index j = 0; j < 6; ++j) {
    const Eigen::Vector3d v = J.col(j).head<3>(), w = J.col(j).tail<3>();
    J.col(j) << T_W_R.linear() * (v + w.cross(p_R_FT)), T_W_R.linear() * w;
  }
  return J;
}

}  // namespace

TrueMounting draw_mounting(const CellLayout& assumed, const SimulationOptions& options,
                           const RobotModel& robot, const Joints& q) {
  const auto seed = static_cast<std::uint64_t>(options.seed);
  Random hand_eye = Random::stream(seed, "hand-eye error");
  TrueMounting mounting{assumed.T_W_R, assumed.T_F_T, assumed.T_T_C, Joints::Zero(), robot, Joints::Zero()};
  Pose error = Pose::Identity();
  error.translation() = options.hand_eye_translation * hand_eye.unit_vector();
  error.linear() = Eigen::AngleAxisd(options.hand_eye_rotation, hand_eye.unit_vector()).toRotationMatrix();
  mounting.T_T_C = assumed.T_T_C * error;
  Random arm = Random::stream(seed, "arm residual");
  const double sigma = joint_sigma(options.arm_residual, robot, assumed.T_F_T, q);
  for (auto& joint : mounting.joint_error) joint = arm.normal(0.0, sigma);
  if (options.arm_kinematics > 0.0)
    mounting.robot =
        draw_links(assumed, options.arm_kinematics, robot, q, Random::stream(seed, "arm kinematics"));
  if (options.base_translation > 0.0 || options.base_rotation > 0.0) {
    Random base = Random::stream(seed, "robot base");
    const Eigen::Vector3d shift = options.base_translation * base.unit_vector();
    mounting.T_W_R = assumed.T_W_R * small_motion(shift, options.base_rotation * base.unit_vector());
  }
  if (options.arm_compliance > 0.0) {
    mounting.joint_compliance = kGearSize.cwiseInverse();
    mounting.joint_compliance *= options.arm_compliance / tool_compliance(mounting, q)(2, 2);
  }
  return mounting;
}

Compliance tool_compliance(const TrueMounting& mounting, const Joints& q) {
  if (mounting.joint_compliance.isZero(0.0)) return Compliance::Zero();
  const Jacobian J = tip_jacobian(mounting.robot, mounting.T_W_R, mounting.T_F_T, q);
  return J * mounting.joint_compliance.asDiagonal() * J.transpose();
}

std::optional<std::string> find_link_hit(const TrueWorld& world, const TrueMounting& mounting,
                                         const Joints& q) {
  const auto links = link_poses(mounting.robot, q + mounting.joint_error);
  const TrueTable& table = world.table();
  for (const auto& capsule : mounting.robot.capsules) {
    if (capsule.link < kFirstLink) continue;
    const Pose T_W_link = mounting.T_W_R * links[static_cast<std::size_t>(capsule.link)];
    const Eigen::Vector3d a = T_W_link * capsule.a, b = T_W_link * capsule.b;
    if (std::min(a.z() - table.height(a), b.z() - table.height(b)) < capsule.radius)
      return concat("link ", capsule.link, " hits the table");
    for (const StoneIndex i : world.present()) {
      const auto& shape = *at(world.shapes(), i);
      if (distance_to_segment(world.centre_of_mass(i), a, b) > capsule.radius + shape.radius) continue;
      for (const auto& sample : shape.samples)
        if (distance_to_segment(world.pose(i) * sample.point, a, b) < capsule.radius)
          return concat("link ", capsule.link, " hits stone ", shape.name);
    }
  }
  return std::nullopt;
}

SimulatedArm::SimulatedArm(TrueWorld& world, const RobotModel& robot, const TrueMounting& mounting,
                           SimulatedForceTorque& force_torque, CellKeeper& keeper,
                           const SimulationOptions& options, const Joints& q, const CellLayout& assumed)
    : world_(&world),
      robot_(robot),
      mounting_(mounting),
      force_torque_(&force_torque),
      keeper_(&keeper),
      random_(Random::stream(static_cast<std::uint64_t>(options.seed), "arm repeatability")),
      jitter_sigma_(joint_sigma(options.arm_repeatability, robot, mounting.T_F_T, q)),
      T_W_R_assumed_(assumed.T_W_R),
      T_F_T_assumed_(assumed.T_F_T),
      q_(q),
      backlash_(options.arm_backlash, q) {
  world.set_compliance(tool_compliance(mounting_, q));
}

Pose SimulatedArm::tool_at(const Joints& output) const {
  return mounting_.T_W_R * forward(mounting_.robot, output + mounting_.joint_error) * mounting_.T_F_T;
}

Pose SimulatedArm::true_T_W_T(const Joints& q) const {
  return tool_at(q);
}

ArmState SimulatedArm::state() {
  ArmState state;
  state.q = q_;
  state.device_time = state.host_time = world_->time();
  state.can_move = stop_reason_.empty();
  state.stop_reason = stop_reason_;
  return state;
}

MotionResult SimulatedArm::follow(const JointTrajectory& trajectory) {
  MotionResult result = move(trajectory, nullptr);
  keeper_->changed(world_->time());
  return result;
}

MotionResult SimulatedArm::carry(const JointTrajectory& trajectory) {
  MotionResult result = move(trajectory, nullptr, gripper_state_);
  keeper_->changed(world_->time());
  return result;
}

MotionResult SimulatedArm::follow_guarded(const GuardedMotion& motion) {
  require(motion.threshold > 0 && std::abs(motion.n_W_direction.norm() - 1) < 1e-6,
          "a guard needs a positive threshold and a unit direction, got ", motion.threshold, " N and length ",
          motion.n_W_direction.norm());
  MotionResult result = move(motion.trajectory, &motion);
  keeper_->changed(world_->time());
  return result;
}

void SimulatedArm::set_payload(double mass, const Eigen::Vector3d& p_F_com) {
  require(std::isfinite(mass) && mass >= 0 && p_F_com.allFinite(),
          "a payload needs a mass and a finite centre, got ", mass, " kg");
  require(mass <= robot_.payload, "the arm carries ", robot_.payload, " kg, not ", mass, " kg");
  payload_ = mass;
}

std::string SimulatedArm::refusal(const JointTrajectory& trajectory) const {
  if (!stop_reason_.empty()) return "protective stop not unlocked: " + stop_reason_;
  return hardware::find_path_fault(trajectory, q_, robot_, {T_W_R_assumed_, T_F_T_assumed_, kControlPeriod});
}

double SimulatedArm::resistance(const GuardedMotion& guard) {
  // As a program would: the reading turned by the arm's nominal pose.
  const Eigen::Matrix3d R_W_F = (T_W_R_assumed_ * forward(robot_, q_)).rotation();
  return -guard.n_W_direction.dot(R_W_F * force_torque_->read().force);
}

MotionResult SimulatedArm::move(const JointTrajectory& trajectory, const GuardedMotion* guard,
                                const std::function<GripperState()>& gripper) {
  using Status = MotionResult::Status;
  if (auto reason = refusal(trajectory); !reason.empty()) return {Status::kRefused, q_, 0.0, reason};
  double start_force = 0.0, force = 0.0;
  if (guard)
    for (int i = 0; i < kStartSamples; ++i) start_force += resistance(*guard) / kStartSamples;
  const Joints start_gap = q_ - trajectory.q.front(), old_jitter = jitter_;
  Joints new_jitter;
  for (auto& joint : new_jitter) joint = random_.normal(0.0, jitter_sigma_);
  const double duration = trajectory.duration();
  const auto reported = [&](double t) -> Joints {
    const double fade = duration > 0 ? smooth(std::min(1.0, t / std::min(duration, 0.5))) : 1.0;
    return sample(trajectory, t).q + (1 - fade) * start_gap;
  };
  int above = 0, tick = 0;
  GuardReadings readings;
  hardware::HoldJudge hold;
  bool dropped = false;
  double speed = 1.0;  // share of the planned one: less once the arm slows down to a stop
  for (double t = 0; t < duration && speed > 0;) {
    throw_if_interrupted();
    const double chunk = std::min(kArmTick, (duration - t) / speed);
    const auto path = [&](double s) {
      const double at = t + speed * s;
      jitter_ = old_jitter + smooth(at / duration) * (new_jitter - old_jitter);
      GripperPose gripper_pose = world_->gripper_pose();
      gripper_pose.T_W_T = tool_at(backlash_.output(reported(at) + jitter_));
      return gripper_pose;
    };
    world_->set_compliance(tool_compliance(mounting_, q_));
    const Progress progress = world_->advance(chunk, path);
    t += speed * progress.seconds;
    if (gripper && !dropped && tick % kTicksPerHold == 0) dropped = hold.lost(gripper());
    if (dropped) speed -= chunk / kStopTime;
    q_ = reported(t);
    backlash_.arrive(q_ + jitter_);
    keeper_->changing(world_->time());
    stop_reason_ = progress.stopped;
    if (stop_reason_.empty() && tick++ % kTicksPerCheck == 0)
      stop_reason_ = find_link_hit(*world_, mounting_, q_).value_or("");
    if (guard) {
      force = resistance(*guard) - start_force;
      readings.add(force);
    }
    if (!stop_reason_.empty()) return {Status::kStopped, q_, force, "protective stop: " + stop_reason_};
    if (guard) above = force > guard->threshold ? above + 1 : 0;
    if (above >= 2)
      return {Status::kContact, q_, force, concat("contact at ", force, " N"),
              readings.mean_of_second_half()};
  }
  if (guard)
    return {Status::kNoContact, q_, force, "no contact up to the end of the motion",
            readings.mean_of_second_half()};
  if (dropped) return {Status::kDropped, q_, 0.0, hardware::kDroppedReason};
  return {Status::kDone, q_, 0.0, {}};
}

}  // namespace stonestack::simulation
