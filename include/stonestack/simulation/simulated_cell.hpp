#pragma once
#include <memory>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::simulation {

class SharedWorld;
class TrueWorld;

/// Errors of the simulated cell. Everything here is hidden from the planner. The defaults are the cell
/// `mild`; `options_of_cell` has the others.
struct SimulationOptions {
  int seed = 1;                         ///< seed of every draw of the world
  std::string cell = "mild";            ///< the named set of errors that the others started from
  std::string engine = "bullet";        ///< of the true world: bullet or ode; the planner's is Bullet
  double friction = 0.5;                ///< true, stone on stone and on the table: mean over pairs
  double friction_spread = 0.15;        ///< half width of the uniform draw per pair
  std::string sensor = "sr300";         ///< depth camera: of data/sensors, a file, or ideal
  bool sensor_noise = true;             ///< of the camera's model and of the force sensor
  double sensor_scale = 1.0;            ///< factor on the errors of the camera's model and the force noise
  double lens_focal = 0.0;              ///< true focal length beside the reported one, as a share
  double lens_centre = 0.0;             ///< true centre of the image beside the reported one [px]
  double lens_distortion = 0.0;         ///< radial, left over in a corner of the image [px]
  double hand_eye_translation = 0.001;  ///< error of T_T_C [m]
  double hand_eye_rotation = 0.005236;  ///< [rad] (0.3 deg)
  double arm_repeatability = 0.0001;    ///< of the tool's tip, root of the mean square [m]
  double arm_residual = 0.001;          ///< calibration residual of the arm, likewise [m]
  double arm_kinematics = 0.0;          ///< error at the tip by links unlike their model, over the cell [m]
  double arm_backlash = 0.0;            ///< lost motion of each joint when it turns back [rad]
  double arm_compliance = 0.0;          ///< how far the tip gives way downwards to 1 N over the field [m/N]
  double base_translation = 0.0;        ///< robot base beside where it was said [m]
  double base_rotation = 0.0;           ///< [rad]
  double table_height = 0.0;            ///< table above or below where it was said [m]
  double table_tilt = 0.0;              ///< [rad]
  double table_unevenness = 0.0;        ///< of the table about its plane, at most [m]
  double force_delay = 0.0;             ///< age of what the wrist sensor reports [s]
  double force_drift = 0.0;             ///< of the wrist sensor's zero, at most [N/s]
  bool gripper_inertia = false;         ///< the wrist sensor feels the gripper's mass accelerate
  double mass_error = 0.02;             ///< share, one sigma
  double com_error = 0.002;             ///< at most [m]
  double scan_error = 0.0;              ///< true surfaces beside their scans, in waves of 20 mm, rms [m]
  double scan_roughness = 0.0;          ///< likewise in waves of 3 mm
  double pad_friction = 0.5;            ///< true, rubber on stone: mean over stones
  double pad_friction_spread = 0.0;     ///< half width of the uniform draw per stone
  double pad_stiffness = 1.5e8;         ///< N/m^3, of the fingers' rubber; a third of it sideways
  double pad_stiffness_spread = 1.0;    ///< factor: the run's pads are stiffer or softer by at most this
  std::string linkage = "parallel";     ///< of the true fingers: parallel or three_finger
  bool regrip = true;                   ///< fingers close further when the held stone yields (rGTO stays set)
  double clearance = 0.045;  ///< distance [m] between loose stones, for the fingers; less in a full field
  int foreign_objects = 0;   ///< boxes and cylinders among the stones that no catalogue has
};
[[nodiscard]] FieldList fields(SimulationOptions& options);

/// The errors that a named cell stands for: ideal (none), mild (the defaults), lab (all at once, as large as
/// in a lab), paper (lab with true friction 0.1 to 0.2) or hard (lab's errors doubled).
/// @throws InvalidArgument for another name.
[[nodiscard]] SimulationOptions options_of_cell(const std::string& cell);
/// "NAME=VALUE" of each option, without `seed` and `cell`, that is not as the options' named cell has it.
[[nodiscard]] std::vector<std::string> changed_in_cell(const SimulationOptions& options);

/// The true state, for judging, drawing and recording ground truth only: never for planning.
struct Truth {
  double time = 0.0;  ///< [s]
  /// by stone index, frames of the catalogue, identity for absent stones; then the foreign objects
  std::vector<Pose> T_W_O;
  std::vector<Contact> contacts;  ///< between stones, numbered as in the catalogue, and with the table
};

/// A UR10 with gripper, force sensor and camera over a table with stones, on a simulated clock.
class SimulatedCell {
 public:
  /// Drops the stones `present` (indices into `stones`) at random places in the field and lets them come to
  /// rest. The arm starts with the camera over the field.
  /// @param kept folder in which another object has kept this cell (`keep_in`): it goes on from there, at
  /// rest; empty: a new one
  /// @throws InvalidArgument when they do not fit; FileError for a folder that holds no such cell.
  SimulatedCell(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
                const RobotModel& robot, const CellLayout& assumed, const SimulationOptions& options = {},
                const std::string& kept = {});
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
  /// Writes the true state into `folder` now and while arm and gripper move, so that another process can go
  /// on with the cell. No planner may read it.
  /// @throws FileError, now and from the devices
  void keep_in(const std::string& folder);
  /// The world itself and the site where the planner expects it, for judges.
  [[nodiscard]] const TrueWorld& world() const;
  /// Site [m] in W where the planner expects the tower.
  [[nodiscard]] const Eigen::Vector2d& site() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Pose of the camera of a rendered scene: its axis passes through the middle of the field.
struct SceneOptions {
  SimulationOptions simulation;  ///< options of the simulated world
  double distance = 0.7;         ///< distance [m] from the camera to the viewed point
  double tilt = 0.174533;        ///< angle [rad] off the vertical (10 deg)
};
/// Without those of `simulation`, which have a list of their own.
[[nodiscard]] FieldList fields(SceneOptions& options);

/// A view of stones on a table, with the truth about it.
struct SimulatedScene {
  DepthImage depth;                 ///< depth image as the sensor gives it
  double depth_unit = 0.0;          ///< metres per count
  Pose T_W_C = Pose::Identity();    ///< true pose of the camera
  std::vector<PlacedStone> stones;  ///< true poses T_W_O
};

/// Scatters the stones `present` in the layout's field and takes one picture. Same seed, same scene.
[[nodiscard]] SimulatedScene render_scene(const std::vector<Stone>& stones,
                                          const std::vector<StoneIndex>& present, const CellLayout& layout,
                                          const SceneOptions& options = {});

/// Writes depth.png (16 bit), cloud.ply (organised, camera frame) and scene.yaml (intrinsics, T_W_C, stones
/// with T_W_O and T_C_O) into the folder.
/// @throws FileError
void write_scene(const std::string& folder, const SimulatedScene& scene, const std::vector<Stone>& stones);

}  // namespace stonestack::simulation

#pragma GCC visibility pop
