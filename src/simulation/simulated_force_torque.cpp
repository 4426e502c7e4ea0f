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

Eigen::Vector3d normals(Random& random, double sigma) {
  const double x = random.normal(0, sigma), y = random.normal(0, sigma);
  return {x, y, random.normal(0, sigma)};
}

Eigen::Vector3d counted(const Eigen::Vector3d& value, double count) {
  return (value / count).array().round() * count;
}

}  // namespace

Eigen::Vector3d gripper_centre() {
  return {0, 0, -0.12};
}

SimulatedForceTorque::SimulatedForceTorque(TrueWorld& world, const TrueMounting& mounting,
                                           const SimulationOptions& options)
    : world_(&world),
      mounting_(mounting),
      random_(Random::stream(static_cast<std::uint64_t>(options.seed), "force sensor")),
      noisy_(options.sensor_noise) {
  if (!noisy_) return;
  offset_.force = normals(random_, kForceOffset);
  offset_.torque = normals(random_, kTorqueOffset);
}

Wrench SimulatedForceTorque::sample() {
  if (world_->time() < last_time_ + 0.5 * kPeriod) world_->wait(kPeriod);
  return measure();
}

Wrench SimulatedForceTorque::measure() {
  last_time_ = world_->time();
  const Pose T_W_F = world_->gripper_pose().T_W_T * mounting_.T_F_T.inverse();
  GripperLoad load = world_->load();
  load.add(world_->gripper_pose().T_W_T * gripper_centre(),
           {0, 0, -kGravity * sensed_mass(world_->gripper_body().gripper)});
  const Eigen::Matrix3d R_F_W = T_W_F.rotation().transpose();
  Wrench wrench;
  wrench.force = R_F_W * load.force + offset_.force;
  wrench.torque = R_F_W * (load.moment - T_W_F.translation().cross(load.force)) + offset_.torque;
  if (noisy_) {
    wrench.force = counted(wrench.force + normals(random_, kForceSigma), kForceCount);
    wrench.torque = counted(wrench.torque + normals(random_, kTorqueSigma), kTorqueCount);
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
