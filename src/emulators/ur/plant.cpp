#include "emulators/ur/plant.hpp"

#include <algorithm>

#include "core/constants.hpp"
#include "simulation/shared_world.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kCheckPeriod = 0.050;  // s between two comparisons of links with table and stones
constexpr double kFade = 0.1;  // s of motion in which the error of the last stop becomes that of the next

class WorldPlant final : public Plant {
 public:
  WorldPlant(SharedWorld& world, const Joints& q, bool has_sensor)
      : world_(&world),
        random_(Random::stream(static_cast<std::uint64_t>(world.options().seed), "arm repeatability")),
        jitter_sigma_(
            joint_sigma(world.options().arm_repeatability, world.robot(), world.mounting().T_F_T, q)),
        backlash_(world.options().arm_backlash, q) {
    state_.q = q;
    if (has_sensor) sensor_.emplace(world.lock().world, world.mounting(), world.options());
  }

  [[nodiscard]] PlantState state() override { return state_; }

  PlantState step(const Joints& q_target, double seconds) override {
    const TrueMounting& mounting = world_->mounting();
    err(q_target != state_.q, seconds);
    backlash_.arrive(q_target);
    const Pose T_R_F = forward(mounting.robot, backlash_.output(q_target) + mounting.joint_error + jitter_);
    const Pose T_W_F = mounting.T_W_R * T_R_F;
    world_->lock().world.set_compliance(tool_compliance(mounting, q_target));
    state_.hit = world_->move_arm(T_W_F * mounting.T_F_T, seconds).stopped;
    state_.qd = (q_target - state_.q) / seconds;
    state_.q = q_target;
    auto access = world_->lock();
    read_wrench(access.world, T_W_F);
    since_check_ += seconds;
    if (state_.hit.empty() && since_check_ >= kCheckPeriod) {
      since_check_ = 0.0;
      state_.hit = find_link_hit(access.world, mounting, state_.q).value_or("");
    }
    return state_;
  }

 private:
  // No two motions end alike, as with the arm in process.
  void err(bool moves, double seconds) {
    if (moves && !moves_)
      for (auto& joint : next_jitter_) joint = random_.normal(0.0, jitter_sigma_);
    if (moves) jitter_ += std::min(1.0, seconds / kFade) * (next_jitter_ - jitter_);
    moves_ = moves;
  }

  // Everything beyond the flange: contact and held stones, and the gripper's own weight.
  void read_wrench(const TrueWorld& world, const Pose& T_W_F) {
    GripperLoad load = world.load();
    load.add(world.gripper_pose().T_W_T * gripper_centre(world.gripper_body().gripper),
             {0, 0, -kGravity * carried_mass(world.gripper_body().gripper)});
    const Eigen::Matrix3d R_R_W = world_->mounting().T_W_R.rotation().transpose();
    state_.force_R = R_R_W * load.force;
    state_.torque_R = R_R_W * (load.moment - T_W_F.translation().cross(load.force));
    if (sensor_) state_.sensed = sense(world.gripper_body().gripper.sensor_mass, T_W_F);
  }

  // A sensor between flange and gripper hangs on this one, too.
  Wrench sense(double sensor_mass, const Pose& T_W_F) {
    Wrench wrench = sensor_->measure();
    wrench.force += T_W_F.rotation().transpose() * Eigen::Vector3d(0, 0, -kGravity * sensor_mass);
    return wrench;
  }

  SharedWorld* world_;
  PlantState state_;
  Random random_;
  double jitter_sigma_;  // rad
  Backlash backlash_;
  Joints jitter_ = Joints::Zero(), next_jitter_ = Joints::Zero();  // rad
  bool moves_ = false;
  double since_check_ = 0.0;
  std::optional<SimulatedForceTorque> sensor_;
};

}  // namespace

std::unique_ptr<Plant> make_world_plant(SharedWorld& world, const Joints& q_start, bool has_sensor) {
  return std::make_unique<WorldPlant>(world, q_start, has_sensor);
}

}  // namespace stonestack::emulators
