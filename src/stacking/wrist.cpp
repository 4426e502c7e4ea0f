#include "stacking/wrist.hpp"

#include <algorithm>

#include "core/constants.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

constexpr int kReadings = 10;
constexpr int kPassedOver = 10;  // readings, 0.1 s: sensors report up to 50 ms late, and arms swing out
constexpr double kDrift = 2.0;   // N, error of the sensor after a carry; design choice
constexpr double kGripperCentre = 0.03;  // m, error of the gripper's assumed centre of mass; design choice
constexpr double kSettle = 1.0;          // s, at most, for fingers that close on

/// Until the sensor reports the rest of an arm that has just stopped.
void pass_over_motion(Cell& cell) {
  for (int i = 0; i < kPassedOver; ++i) (void)cell.force_torque.read();
}

Wrench mean_reading(Cell& cell) {
  pass_over_motion(cell);
  Wrench mean;
  for (int i = 0; i < kReadings; ++i) {
    const Wrench one = cell.force_torque.read();
    mean.force += one.force / kReadings;
    mean.torque += one.torque / kReadings;
  }
  return mean;
}

}  // namespace

Eigen::Vector3d Wrist::down() const {
  return -(cell_.layout.T_W_R * forward(robot_, cell_.arm.state().q)).linear().row(2).transpose();
}

void Wrist::zero(double carried_weight) {
  pass_over_motion(cell_);
  cell_.force_torque.zero();
  carried_at_zero_ = carried_weight;
  n_F_down_at_zero_ = down();
}

Eigen::Vector3d Wrist::force_W() const {
  return (cell_.layout.T_W_R * forward(robot_, cell_.arm.state().q)).linear() * mean_reading(cell_).force;
}

WristLoad Wrist::feel() const {
  const Wrench mean = mean_reading(cell_);
  WristLoad load;
  load.n_F_down = down();
  const Eigen::Vector3d f_F_tilt = kGravity * gripper_.mass * (load.n_F_down - n_F_down_at_zero_);
  const Eigen::Vector3d force = mean.force - f_F_tilt;
  const Eigen::Vector3d torque = mean.torque - gripper_.p_F_gripper.cross(f_F_tilt);
  load.weight = carried_at_zero_ + force.dot(load.n_F_down);
  load.p_F_pull = force.cross(torque) / std::max(1e-6, force.squaredNorm());
  load.uncertainty = kGripperCentre * f_F_tilt.norm() / std::max(1e-3, force.norm());
  return load;
}

double beside(const WristLoad& load, const Eigen::Vector3d& p_F) {
  const Eigen::Vector3d off = load.p_F_pull - p_F;
  return (off - off.dot(load.n_F_down) * load.n_F_down).norm();
}

bool reports_object_at_rest(Cell& cell) {
  const double start = cell.clock.now();
  GripperState state = cell.gripper.state();
  while (state.moving && cell.clock.now() < start + kSettle) {
    (void)cell.force_torque.read();  // paced by its samples
    state = cell.gripper.state();
  }
  return state.object;
}

double max_in_empty_gripper(double weight) {
  return std::max(kDrift, kEmptyGripper * weight);
}

CarriedLoad feel_carried(const Wrist& wrist, Cell& cell, double expected, double min_held_share) {
  CarriedLoad carried{wrist.feel(), true};
  const double weight = carried.load.weight;
  if (weight < min_held_share * expected)
    carried.held = weight >= kEmptyGripper * expected && reports_object_at_rest(cell);
  return carried;
}

}  // namespace stonestack::stacking
