#pragma once
#include <memory>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack {

/// How true the simulated cell is. Everything here is hidden from the planner.
struct SimulationOptions {
  int seed = 1;
  double friction = 0.5;                ///< true, stone on stone: mean over pairs
  double friction_spread = 0.15;        ///< half width of the uniform draw per pair
  bool sensor_noise = true;             ///< SR300 model (facts/detection.md §1)
  double hand_eye_translation = 0.001;  ///< m, error of T_T_C
  double hand_eye_rotation = 0.0052;    ///< rad (0.3 deg)
  double arm_repeatability = 0.0001;    ///< m
  double arm_residual = 0.001;          ///< m, calibration residual of the arm
  double mass_error = 0.02;             ///< share
  double com_error = 0.002;             ///< m
  double step = 1.0 / 240.0;            ///< s
};
[[nodiscard]] FieldList fields(SimulationOptions& options);

/// The true state, for judging, drawing and recording ground truth only: never for planning.
struct Truth {
  double time = 0.0;              ///< s
  std::vector<Pose> T_W_O;        ///< by stone index; frames of the catalogue
  std::vector<Contact> contacts;  ///< between stones and with the table
};

/// A UR10 with gripper, force sensor and camera over a table with stones, in Bullet, on a simulated clock.
class SimulatedCell {
 public:
  /// Drops the stones `present` (indices into `stones`) at random places in the field and lets them come to
  /// rest.
  SimulatedCell(const std::vector<Stone>& stones, const std::vector<int>& present, const RobotModel& robot,
                const CellLayout& believed, const SimulationOptions& options = {});
  ~SimulatedCell();

  /// The devices, as the program may use them.
  [[nodiscard]] Cell cell();
  /// For the judge and the painter.
  [[nodiscard]] Truth truth() const;
  /// Lets simulated time pass with the arm where it is.
  void wait(double seconds);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack
