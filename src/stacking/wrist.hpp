#pragma once
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to stacking/: load on the gripper, measured at the wrist.
namespace stonestack::stacking {

/// Mass of the constant load on the sensor.
struct GripperMass {
  double mass = 0.0;                                      ///< [kg]
  Eigen::Vector3d p_F_gripper = Eigen::Vector3d::Zero();  ///< centre of mass [m]
};

/// Load on the wrist beside the gripper itself.
struct WristLoad {
  double weight = 0.0;  ///< downwards [N]
  /// A point on the line of action of the load applied since taring, level with F.
  Eigen::Vector3d p_F_pull = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_F_down = -Eigen::Vector3d::UnitZ();  ///< in the arm's present pose
  /// Error of that line [m]: the gripper's centre of mass is known to 3 cm, and its effect changes with the
  /// tilt.
  double uncertainty = 0.0;
};

/// Horizontal distance of the load's line of action from a point of the flange's frame [m]; only that
/// component of a weight's lever can be observed.
[[nodiscard]] double beside(const WristLoad& load, const Eigen::Vector3d& p_F);

/// Share of a stone's weight: a lighter load means that the stone is lost.
inline constexpr double kEmptyGripper = 0.2;

/// The force sensor and the pose in which it was tared: taring removes the gripper's weight in that pose, so
/// the difference in another pose is subtracted.
class Wrist {
 public:
  Wrist(Cell& cell, const RobotModel& robot, const GripperMass& gripper)
      : cell_(cell), robot_(robot), gripper_(gripper), n_F_down_at_zero_(down()) {}

  /// Tares at rest. `carried_weight`: present load of the gripper (N), so that its loss is measured later.
  void zero(double carried_weight = 0.0);
  /// Mean of a tenth of a second, at rest, a tenth of a second after the call.
  [[nodiscard]] WristLoad feel() const;
  /// Force of the world on the gripper and what it holds since taring, in W [N]. For the pose of taring only.
  [[nodiscard]] Eigen::Vector3d force_W() const;

 private:
  [[nodiscard]] Eigen::Vector3d down() const;

  Cell& cell_;
  const RobotModel& robot_;
  GripperMass gripper_;
  Eigen::Vector3d n_F_down_at_zero_;
  double carried_at_zero_ = 0.0;
};

/// Object that the gripper reports once its fingers have come to rest: they close on one that slips.
[[nodiscard]] bool reports_object_at_rest(Cell& cell);

/// Largest load of an empty gripper [N]: a stone of `weight` (N) mostly rests on the tower while a finger
/// still holds it, and the sensor drifts during a carry.
[[nodiscard]] double max_in_empty_gripper(double weight);

/// Load that is left in the gripper of a stone that was carried.
struct CarriedLoad {
  WristLoad load;
  bool held = false;
};

/// Combines wrist and gripper. A load of at least `min_held_share` of the weight (`expected`, N) means that
/// the stone is held; below `kEmptyGripper` of it the wrist feels none, whatever the gripper reports, which
/// reports late. Between the two the gripper decides, when its fingers
/// have come to rest: they close on a stone that slips, and are no verdict while they do.
[[nodiscard]] CarriedLoad feel_carried(const Wrist& wrist, Cell& cell, double expected,
                                       double min_held_share);

}  // namespace stonestack::stacking
