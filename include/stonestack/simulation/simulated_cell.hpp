#pragma once
#include <memory>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/physics/stack.hpp"

#pragma GCC visibility push(default)

namespace stonestack::simulation {

class SharedWorld;
class TrueWorld;

/// How true the simulated cell is. Everything here is hidden from the planner.
struct SimulationOptions {
  int seed = 1;                         ///< seed of every draw of the world
  std::string engine = "bullet";        ///< of the true world: bullet or ode; the planner's is Bullet
  double friction = 0.5;                ///< true, stone on stone and on the table: mean over pairs
  double friction_spread = 0.15;        ///< half width of the uniform draw per pair
  std::string sensor = "sr300";         ///< depth camera: sr300, d435 or ideal
  bool sensor_noise = true;             ///< of the camera's model and of the force sensor
  double hand_eye_translation = 0.001;  ///< error of T_T_C [m]
  double hand_eye_rotation = 0.005236;  ///< [rad] (0.3 deg)
  double arm_repeatability = 0.0001;    ///< of the tool's tip, root of the mean square [m]
  double arm_residual = 0.001;          ///< calibration residual of the arm, likewise [m]
  double force_delay = 0.0;             ///< from the wrist's force to the arm that guards a motion by it [s]
  double mass_error = 0.02;             ///< share, one sigma
  double com_error = 0.002;             ///< at most [m]
  double scan_error = 0.0;              ///< root of the mean square [m]: true surfaces beside their scans
  double pad_friction = 0.5;            ///< true, rubber on stone: mean over stones
  double pad_friction_spread = 0.0;     ///< half width of the uniform draw per stone
  double pad_stiffness = 1.5e8;         ///< N/m^3, of the fingers' rubber; a third of it sideways
  bool regrip = true;                   ///< fingers close further when the held stone yields (rGTO stays set)
  double clearance = 0.045;  ///< distance [m] between loose stones, for the fingers; less in a full field
};
[[nodiscard]] FieldList fields(SimulationOptions& options);

/// The true state, for judging, drawing and recording ground truth only: never for planning.
struct Truth {
  double time = 0.0;              ///< [s]
  std::vector<Pose> T_W_O;        ///< by stone index; frames of the catalogue; identity for absent stones
  std::vector<Contact> contacts;  ///< between stones, numbered as in the catalogue, and with the table
};

/// A UR10 with gripper, force sensor and camera over a table with stones, on a simulated clock.
class SimulatedCell {
 public:
  /// Drops the stones `present` (indices into `stones`) at random places in the field and lets them come to
  /// rest. The arm starts with the camera over the field.
  /// @throws InvalidArgument when they do not fit.
  SimulatedCell(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
                const RobotModel& robot, const CellLayout& assumed, const SimulationOptions& options = {});
  ~SimulatedCell();

  /// The devices, as the program may use them.
  [[nodiscard]] Cell cell();
  /// For the judge and the painter.
  [[nodiscard]] Truth truth() const;
  /// Returns the world for devices behind sockets, each with a thread of its own. While they run, only they
  /// may touch the world: `cell`, `wait` and `world` are for before and after.
  [[nodiscard]] SharedWorld& shared();
  /// Lets simulated time pass with the arm where it is.
  void wait(double seconds);
  /// Puts stone `stone` at T_W_O, at rest, at once: for setting up an experiment, never during one.
  void place(StoneIndex stone, const Pose& T_W_O);
  /// Acknowledges a protective stop, as a person does at the pendant.
  void unlock();
  /// The world itself and the site where the planner expects it, for judges.
  [[nodiscard]] const TrueWorld& world() const;
  /// Site [m] in W where the planner expects the tower.
  [[nodiscard]] const Eigen::Vector2d& site() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::simulation

#pragma GCC visibility pop
