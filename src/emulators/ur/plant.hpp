#pragma once
#include <memory>
#include <optional>
#include <string>

#include "stonestack/hardware/devices.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::simulation {
class SharedWorld;
}

namespace stonestack::emulators {

/// State of a robot's joints and flange, as its controller measures it.
struct PlantState {
  Joints q = Joints::Zero();                          ///< encoders [rad]
  Joints qd = Joints::Zero();                         ///< [rad/s]
  Eigen::Vector3d force_R = Eigen::Vector3d::Zero();  ///< force [N] on the flange by all beyond it, axes of R
  Eigen::Vector3d torque_R = Eigen::Vector3d::Zero();  ///< torque [Nm] about the flange's origin, axes of R
  std::string hit;  ///< what the arm ran into in the last step; empty: nothing
  /// Reading of the sensor in the flange with its errors, axes of F; empty: it has none, or no errors.
  std::optional<Wrench> sensed;
};

/// The mechanics that a simulated controller moves: joint targets in, what became of them out.
class Plant {
 public:
  virtual ~Plant() = default;
  [[nodiscard]] virtual PlantState state() = 0;
  /// Lets `seconds` pass while the joints go to `q_target`.
  virtual PlantState step(const Joints& q_target, double seconds) = 0;
};

/// Joints that follow at once, with a wrench that a test sets.
class IdealPlant final : public Plant {
 public:
  explicit IdealPlant(const Joints& q) { state_.q = q; }
  [[nodiscard]] PlantState state() override { return state_; }
  PlantState step(const Joints& q_target, double seconds) override;
  /// From now on; axes of R. Call it while no controller runs, or from the controller's thread.
  void set_wrench(const Eigen::Vector3d& force_R, const Eigen::Vector3d& torque_R);

 private:
  PlantState state_;
};

/// The arm of a simulated cell: true flange pose, contact, gravity on gripper and held stone. Starts where
/// the cell's arm stands; `q_start` are its reported joints. With `has_sensor` it has a sensor in its flange,
/// with the errors of the world's force sensor. The world must outlive it.
[[nodiscard]] std::unique_ptr<Plant> make_world_plant(SharedWorld& world, const Joints& q_start,
                                                      bool has_sensor = false);

}  // namespace stonestack::emulators
