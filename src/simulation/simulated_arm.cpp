#include <algorithm>
#include <cmath>
#include <deque>

#include "hardware/guard_readings.hpp"
#include "kinematics/jacobian.hpp"
#include "simulation/simulated_devices.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kArmTick = 0.010;        // s, control and force samples
constexpr double kStartTolerance = 0.01;  // rad, hardware/arm.hpp
constexpr int kFirstLink = 2;             // links below the upper arm stand on the table
constexpr int kTicksPerCheck = 5;         // links are compared with table and stones every 50 ms
constexpr int kStartSamples = 10;         // whose mean is a guarded motion's start value

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

TrueMounting draw_mounting(const CellLayout& assumed, const SimulationOptions& options,
                           const RobotModel& robot, const Joints& q) {
  const auto seed = static_cast<std::uint64_t>(options.seed);
  Random hand_eye = Random::stream(seed, "hand-eye error");
  TrueMounting mounting{assumed.T_W_R, assumed.T_F_T, assumed.T_T_C, Joints::Zero()};
  Pose error = Pose::Identity();
  error.translation() = options.hand_eye_translation * hand_eye.unit_vector();
  error.linear() = Eigen::AngleAxisd(options.hand_eye_rotation, hand_eye.unit_vector()).toRotationMatrix();
  mounting.T_T_C = assumed.T_T_C * error;
  Random arm = Random::stream(seed, "arm residual");
  const double sigma = joint_sigma(options.arm_residual, robot, assumed.T_F_T, q);
  for (auto& joint : mounting.joint_error) joint = arm.normal(0.0, sigma);
  return mounting;
}

std::optional<std::string> find_link_hit(const TrueWorld& world, const RobotModel& robot,
                                         const TrueMounting& mounting, const Joints& q) {
  const auto links = link_poses(robot, q + mounting.joint_error);
  for (const auto& capsule : robot.capsules) {
    if (capsule.link < kFirstLink) continue;
    const Pose T_W_link = mounting.T_W_R * links[static_cast<std::size_t>(capsule.link)];
    const Eigen::Vector3d a = T_W_link * capsule.a, b = T_W_link * capsule.b;
    if (std::min(a.z(), b.z()) < capsule.radius) return concat("link ", capsule.link, " hits the table");
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
                           SimulatedForceTorque& force_torque, const SimulationOptions& options,
                           const Joints& q)
    : world_(&world),
      robot_(robot),
      mounting_(mounting),
      force_torque_(&force_torque),
      random_(Random::stream(static_cast<std::uint64_t>(options.seed), "arm repeatability")),
      jitter_sigma_(joint_sigma(options.arm_repeatability, robot, mounting.T_F_T, q)),
      force_delay_(options.force_delay),
      q_(q) {}

Pose SimulatedArm::true_T_W_T(const Joints& q) const {
  return mounting_.T_W_R * forward(robot_, q + mounting_.joint_error) * mounting_.T_F_T;
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
  return move(trajectory, nullptr);
}

MotionResult SimulatedArm::follow_guarded(const GuardedMotion& motion) {
  require(motion.threshold > 0 && std::abs(motion.n_W_direction.norm() - 1) < 1e-6,
          "a guard needs a positive threshold and a unit direction, got ", motion.threshold, " N and length ",
          motion.n_W_direction.norm());
  return move(motion.trajectory, &motion);
}

void SimulatedArm::set_payload(double mass, const Eigen::Vector3d& p_F_com) {
  require(std::isfinite(mass) && mass >= 0 && p_F_com.allFinite(),
          "a payload needs a mass and a finite centre, got ", mass, " kg");
  require(mass <= robot_.payload, "the arm carries ", robot_.payload, " kg, not ", mass, " kg");
  payload_ = mass;
}

std::string SimulatedArm::refusal(const JointTrajectory& trajectory) const {
  if (!stop_reason_.empty()) return "protective stop not unlocked: " + stop_reason_;
  if (std::string fault = malformed(trajectory); !fault.empty()) return fault;
  for (std::size_t k = 0; k < trajectory.q.size(); ++k)
    if (((trajectory.q[k] - robot_.upper).array() > 1e-6).any() ||
        ((robot_.lower - trajectory.q[k]).array() > 1e-6).any())
      return concat("knot ", k, " lies outside the joint limits: ", trajectory.q[k].transpose());
  constexpr double kWorkspaceSlack = 1e-4, kCheckPeriod = 0.008;  // m, s
  const double duration = robot_.workspace ? trajectory.duration() : 0.0;
  for (double t = 0.0; t < duration + kCheckPeriod; t += kCheckPeriod)
    if (auto outside = describe_outside_workspace(robot_, sample(trajectory, t).q, kWorkspaceSlack);
        !outside.empty())
      return concat(outside, ", at ", t, " s");
  const double gap = (trajectory.q.front() - q_).cwiseAbs().maxCoeff();
  if (gap > kStartTolerance)
    return concat("the trajectory starts ", gap, " rad from where the arm is (allowed ", kStartTolerance,
                  ")");
  return {};
}

std::string SimulatedArm::overspeed(const Joints& qd, double t) const {
  for (int j = 0; j < 6; ++j)
    if (std::abs(qd[j]) > 1.01 * robot_.velocity[j])
      return concat("joint ", j + 1, " at ", std::abs(qd[j]), " rad/s, limit ", robot_.velocity[j],
                    " rad/s, at ", t, " s");
  return {};
}

double SimulatedArm::resistance(const GuardedMotion& guard) {
  // As a program would: the reading turned by the arm's nominal pose.
  const Eigen::Matrix3d R_W_F = (mounting_.T_W_R * forward(robot_, q_)).rotation();
  return -guard.n_W_direction.dot(R_W_F * force_torque_->read().force);
}

MotionResult SimulatedArm::move(const JointTrajectory& trajectory, const GuardedMotion* guard) {
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
  // What the guard knows is force_delay old; before the motion the force was the one it started with.
  std::deque<double> felt(static_cast<std::size_t>(std::lround(force_delay_ / kArmTick)), 0.0);
  for (double t = 0; t < duration;) {
    throw_if_interrupted();
    const double chunk = std::min(kArmTick, duration - t);
    const auto path = [&](double s) {
      jitter_ = old_jitter + smooth((t + s) / duration) * (new_jitter - old_jitter);
      GripperPose gripper_pose = world_->gripper_pose();
      gripper_pose.T_W_T = true_T_W_T(reported(t + s) + jitter_);
      return gripper_pose;
    };
    const Progress progress = world_->advance(chunk, path);
    t += progress.seconds;
    q_ = reported(t);
    stop_reason_ = progress.stopped;
    if (stop_reason_.empty()) stop_reason_ = overspeed(sample(trajectory, t).qd, t);
    if (stop_reason_.empty() && tick++ % kTicksPerCheck == 0)
      stop_reason_ = find_link_hit(*world_, robot_, mounting_, q_).value_or("");
    if (guard) {
      felt.push_back(resistance(*guard) - start_force);
      force = felt.front();
      felt.pop_front();
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
  return {Status::kDone, q_, 0.0, {}};
}

}  // namespace stonestack::simulation
