#pragma once
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to stacking/: what hangs in the hand, as the wrist feels it.
namespace stonestack::stacking {

/// Of what the sensor carries always.
struct GripperMass {
  double mass = 0.0;                                      ///< [kg]
  Eigen::Vector3d p_F_gripper = Eigen::Vector3d::Zero();  ///< centre of mass [m]
};

/// Load on the wrist beside the gripper itself.
struct WristLoad {
  double weight = 0.0;  ///< downwards [N]
  /// On the line along which that pulls which came after the zero was taken, level with F.
  Eigen::Vector3d p_F_pull = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_F_down = -Eigen::Vector3d::UnitZ();  ///< as the arm stands
  /// by which that line may be wrong [m]: where the hand's own weight pulls is known to 3 cm, and how it
  /// pulls changes with the tilt.
  double uncertainty = 0.0;
};

/// how far the line along which it pulls passes a point of the flange's frame, level [m]; of the arm of a
/// weight only that part can be told.
[[nodiscard]] double beside(const WristLoad& load, const Eigen::Vector3d& p_F);

/// Share of a stone's weight: when less hangs in the hand, the stone does not.
inline constexpr double kEmptyGripper = 0.2;

/// The force sensor, with where its zero was taken: the sensor forgets the hand's own weight as it hung then,
/// so what a hand that is tilted otherwise weighs now is taken off.
class Wrist {
 public:
  Wrist(Cell& cell, const RobotModel& robot, const GripperMass& gripper)
      : cell_(cell), robot_(robot), gripper_(gripper), n_F_down_at_zero_(down()) {}

  /// At rest. `carried_weight`: what hangs in the hand now (N), so that it is still told of when it has gone.
  void zero(double carried_weight = 0.0);
  /// Mean of a tenth of a second, at rest.
  [[nodiscard]] WristLoad feel() const;

 private:
  [[nodiscard]] Eigen::Vector3d down() const;

  Cell& cell_;
  const RobotModel& robot_;
  GripperMass gripper_;
  Eigen::Vector3d n_F_down_at_zero_;
  double carried_at_zero_ = 0.0;
};

/// so much more than nothing hangs in a hand that is not empty [N]: the stone's `weight` (N) for the most
/// part rests on the tower while a finger still has it, and the sensor drifts while it is carried.
[[nodiscard]] double max_in_empty_gripper(double weight);

/// Load that is left in the gripper of a stone that was carried.
struct CarriedLoad {
  WristLoad load;
  bool held = false;
};

/// Two witnesses. Of a stone that hangs by `min_held_share` of its weight (`expected`, N) the fingers may
/// have lost some, not the stone; where less than `kEmptyGripper` of it hangs the stone is gone, also while
/// the gripper still says otherwise, as it tells late. Between the two the gripper decides, when its fingers
/// have come to rest: they close on a stone that slips, and are no verdict while they do.
[[nodiscard]] CarriedLoad feel_carried(const Wrist& wrist, Cell& cell, double expected,
                                       double min_held_share);

}  // namespace stonestack::stacking
