#include <cmath>

#include "core/constants.hpp"
#include "simulation/simulated_devices.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kPeriod = 0.010;                           // s
constexpr double kForceSigma = 0.3, kTorqueSigma = 0.005;   // N, Nm: design choice, a few counts
constexpr double kForceCount = 0.1, kTorqueCount = 0.001;   // N (data sheet), Nm
constexpr double kForceOffset = 2.0, kTorqueOffset = 0.05;  // N, Nm: unknown at power-up
constexpr int kZeroSamples = 20;
constexpr double kDriftPeriod = 300.0;  // s, of the zero's slow wandering; design choice
constexpr double kTorqueDrift = kTorqueOffset / kForceOffset;  // m, of torque to force

Eigen::Vector3d normals(Random& random, double sigma) {
  const double x = random.normal(0, sigma), y = random.normal(0, sigma);
  return {x, y, random.normal(0, sigma)};
}

Eigen::Vector3d counted(const Eigen::Vector3d& value, double count) {
  return (value / count).array().round() * count;
}

}  // namespace

Eigen::Vector3d gripper_centre(const GripperModel& gripper) {
  constexpr double kBesidePlans = -0.12 - -0.14;  // m
  return {0, 0, gripper.centre_of_mass + kBesidePlans};
}

SimulatedForceTorque::SimulatedForceTorque(TrueWorld& world, const TrueMounting& mounting,
                                           const SimulationOptions& options)
    : world_(&world),
      mounting_(mounting),
      random_(Random::stream(static_cast<std::uint64_t>(options.seed), "force sensor")),
      noisy_(options.sensor_noise) {
  if (options.force_drift > 0.0) {
    Random drift = Random::stream(static_cast<std::uint64_t>(options.seed), "force sensor drift");
    n_F_drift_ = drift.unit_vector();
    n_F_torque_drift_ = drift.unit_vector();
    drift_phase_ = drift.uniform(0.0, kTwoPi);
  }
  if (!noisy_) return;
  offset_.force = normals(random_, kForceOffset);
  offset_.torque = normals(random_, kTorqueOffset);
}

Wrench SimulatedForceTorque::sample() {
  if (world_->time() < last_time_ + 0.5 * kPeriod) world_->wait(kPeriod);
  return measure();
}

// A sine whose steepest slope is the drift asked for, N.
double SimulatedForceTorque::drift() const {
  const double number = kTwoPi / kDriftPeriod;
  return world_->options().force_drift / number * std::sin(number * last_time_ + drift_phase_);
}

Wrench SimulatedForceTorque::measure() {
  last_time_ = world_->time();
  const SimulationOptions& options = world_->options();
  const GripperModel& gripper = world_->gripper_body().gripper;
  const GripperMoment then = world_->moment_before(options.force_delay);
  const Pose T_W_F = then.T_W_T * mounting_.T_F_T.inverse();
  GripperLoad load = then.load;
  load.add(then.T_W_T * gripper_centre(gripper), {0, 0, -kGravity * sensed_mass(gripper)});
  if (options.gripper_inertia)
    load.add(then.T_W_T * gripper_centre(gripper), -sensed_mass(gripper) * then.a_W);
  const Eigen::Matrix3d R_F_W = T_W_F.rotation().transpose();
  Wrench wrench;
  wrench.force = R_F_W * load.force + offset_.force;
  wrench.torque = R_F_W * (load.moment - T_W_F.translation().cross(load.force)) + offset_.torque;
  if (options.force_drift > 0.0) {
    wrench.force += drift() * n_F_drift_;
    wrench.torque += kTorqueDrift * drift() * n_F_torque_drift_;
  }
  if (noisy_) {
    const double scale = options.sensor_scale;
    wrench.force = counted(wrench.force + normals(random_, scale * kForceSigma), kForceCount);
    wrench.torque = counted(wrench.torque + normals(random_, scale * kTorqueSigma), kTorqueCount);
  }
  wrench.device_time = wrench.host_time = last_time_;
  return wrench;
}

Wrench SimulatedForceTorque::read() {
  Wrench wrench = sample();
  wrench.force -= zero_.force;
  wrench.torque -= zero_.torque;
  return wrench;
}

void SimulatedForceTorque::zero() {
  Wrench mean;
  for (int i = 0; i < kZeroSamples; ++i) {
    const Wrench wrench = sample();
    mean.force += wrench.force / kZeroSamples;
    mean.torque += wrench.torque / kZeroSamples;
  }
  zero_ = mean;
}

}  // namespace stonestack::simulation
