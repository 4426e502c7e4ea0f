#include "emulators/ur/plant.hpp"

namespace stonestack::emulators {

PlantState IdealPlant::step(const Joints& q_target, double seconds) {
  state_.qd = (q_target - state_.q) / seconds;
  state_.q = q_target;
  return state_;
}

void IdealPlant::set_wrench(const Eigen::Vector3d& force_R, const Eigen::Vector3d& torque_R) {
  state_.force_R = force_R;
  state_.torque_R = torque_R;
}

}  // namespace stonestack::emulators
