#pragma once
#include <array>
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/geometry/obstacle.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::motion {

/// Motion of the finger tips along z of T while the fingers close.
enum class Linkage {
  kParallel,     ///< none: jaws that slide across
  kThreeFinger,  ///< on an arc, as the phalanges of the Robotiq 3-finger gripper turn about their first joint
  kArc           ///< on the arc of the gripper's own file; its fingers stay upright
};
/// Finds a linkage by its name, "parallel" or "three_finger".
/// @throws InvalidArgument for another name.
[[nodiscard]] Linkage linkage_named(const std::string& name);

/// A box of the gripper, in T (z out of the gripper, x the closing direction), that moves with a finger or
/// not at all.
struct GripperBox {
  Eigen::Vector3d size;        ///< edges of the box [m]
  Eigen::Vector3d p_T_centre;  ///< with the fingers closed (opening 0)
  double finger_side = 0.0;    ///< moves by that times opening / 2 along x: +1 or -1, less near the palm
  double spread = 0.0;         ///< moves along y by that times the change of the spacing of B and C
  bool camera = false;         ///< goes where the camera is mounted
  double advance = 0.0;        ///< moves along z by that times how far the tips stand before z = 0
};

/// Where the finger tips of a gripper with Linkage::kArc stand.
struct TipAdvance {
  double opening = 0.0;  ///< between the pads [m]
  double advance = 0.0;  ///< z in T of the tips [m]
};

/// A gripper. The defaults are those of the Robotiq 3-finger gripper in pinch: finger A at +x, fingers B and
/// C at -x, 73 mm apart in y (measured on the meshes that Robotiq publishes). A gripper with one finger
/// against one has no C: B stands at y = 0, and `finger_spacing` is 0. The origin of T lies at the height of
/// the finger tips when they are fully open; the tips of kThreeFinger and kArc stand further out when they
/// close.
struct GripperModel {
  std::string name = "robotiq-3f";  ///< as in its file
  int against = 2;                  ///< fingers that face A: B and C, or B alone
  double tip = 0.223;               ///< of the open fingers from the gripper's mount [m]
  double max_opening = 0.155;       ///< [m]
  double min_object = 0.020;        ///< [m]
  double finger_width = 0.031;      ///< along y [m]
  double finger_spacing = 0.073;    ///< between B and C where their pads are [m]
  double narrow_spacing = 0.042;    ///< the same with B and C drawn together [m]; 0: the gripper cannot
  double pad_length = 0.040;        ///< along z, ends at the finger tip [m]
  double force = 60.0;              ///< force a finger, in plans [N]
  double min_force = 15.0;          ///< that the gripper can be set to, a finger [N]
  double max_force = 60.0;          ///< likewise
  double min_speed = 0.022;         ///< of the opening [m/s]
  double max_speed = 0.110;         ///< likewise
  double friction = 0.5;            ///< rubber on stone
  double pad_thickness = 0.005;     ///< thickness of rubber [m]
  double pad_stiffness = 1.5e8;     ///< N/m^3, pressure over depth: 5 mm of soft rubber (E about 0.75 MPa)
  double pad_shear = 5e7;           ///< N/m^3, sideways: a third of it
  double mass = 2.5;                ///< of the gripper alone [kg]
  double centre_of_mass = -0.14;    ///< of the gripper alone, z in T [m]
  double sensor_mass = 0.65;        ///< of the force sensor behind it (Robotiq FT150 [kg]; FT300: 0.30)
  double camera_mass = 0.20;        ///< of camera, bracket and cable [kg]; design choice
  double payload = 2.5;             ///< mass [kg] at the finger tips
  std::vector<GripperBox> boxes;    ///< fingers, palm, sensor, camera

  Linkage linkage = Linkage::kParallel;  ///< path of the finger tips
  std::vector<TipAdvance> tips;          ///< that of kArc, by rising opening; empty: straight
};
/// Reads a gripper by the name that comes with stonestack ("robotiq-2f-85") or the path of its YAML
/// (docs/formats.md). `linkage` kThreeFinger stands for the true path of any gripper's tips: the arc of its
/// file where it is not the 3-finger gripper. A file is read once.
/// @throws FileError that names file, key, value and remedy.
[[nodiscard]] GripperModel read_gripper(const std::string& name_or_path,
                                        Linkage linkage = Linkage::kParallel);
/// Grippers that come with stonestack.
[[nodiscard]] std::vector<std::string> gripper_names();
/// With its boxes.
[[nodiscard]] GripperModel make_robotiq_3f(Linkage linkage = Linkage::kParallel);
/// Gripper and camera [kg]: what the force sensor carries without a stone.
[[nodiscard]] double sensed_mass(const GripperModel& gripper);
/// Gripper, camera and sensor [kg]: what the arm carries without a stone.
[[nodiscard]] double carried_mass(const GripperModel& gripper);
/// The gripper with fingers B and C `spacing` (m) apart at their pads. Throws InvalidArgument for a spacing
/// that is neither `finger_spacing` nor between it and `narrow_spacing`.
[[nodiscard]] GripperModel with_spacing(GripperModel gripper, double spacing);

/// The gripper with its camera mounted at T_T_C instead of CellLayout::make_default_T_T_C(): the box around
/// camera and bracket moves with it and grows to the box along T's axes that holds it. A mount within 10 mm
/// and 3 deg of the default, as a calibration finds it, keeps the default's box.
/// @throws InvalidArgument for what is no rigid transform.
[[nodiscard]] GripperModel with_camera_at(GripperModel gripper, const Pose& T_T_C);

/// A convex obstacle or one convex piece of a stone, with its own name for messages.
struct SceneObject {
  std::string name;                    ///< name for messages
  std::vector<Mesh> pieces;            ///< convex, in the object's frame
  Pose T_W_object = Pose::Identity();  ///< pose of the object in W
};

/// Everything that a motion must not touch, as estimated.
struct PlanningScene {
  RobotModel robot;                          ///< arm
  GripperModel gripper = make_robotiq_3f();  ///< gripper at the flange
  Pose T_W_R = Pose::Identity();             ///< pose of the robot base
  Pose T_F_T = Pose::Identity();             ///< pose of the tool tip at the flange
  double table_z = 0.0;                      ///< the half space below is solid [m]
  double opening = 0.155;                    ///< of the empty gripper while `plan_transit` moves it [m]
  std::vector<SceneObject> objects;          ///< loose stones, stack, user's boxes and meshes
  std::vector<PairPadding> paddings;  ///< users', instead of a motion's padding unless that is 0 (contact)
};
/// Distance that moving parts keep from obstacles [m]: of the user's paddings that name both the last,
/// otherwise `padding`, which alone counts where it is 0. `part`: "arm", "gripper" or "held"; `link`:
/// "forearm", or the part again.
[[nodiscard]] double padding_between(const PlanningScene& scene, const std::string& part,
                                     const std::string& link, const std::string& stands, double padding);

/// Narrowest horizontal width of a stone that stands on a table [m]: over its resting poses (`rest_poses`)
/// and all turns about the vertical. A gripper from above that is to hold it about its middle opens that wide
/// at least. 0 for a stone without a firm resting pose. Throws InvalidArgument as `rest_poses`.
[[nodiscard]] double min_width_at_rest(const Stone& stone);

/// Why no grasp from above picks the stone up, however it lies: "162 mm across, the fingers open 155 mm";
/// empty if its weight and its width do not stand in the way.
/// @throws InvalidArgument as `rest_poses`.
[[nodiscard]] std::string unfit_for_gripper(const Stone& stone, const GripperModel& gripper);

/// Checks the arm that carries gripper and stone, too: "1.7 kg, ur5 carries 5 kg, 3.35 kg of them the gripper
/// with sensor and camera".
[[nodiscard]] std::string unfit_for_gripper(const Stone& stone, const GripperModel& gripper,
                                            const RobotModel& robot);

/// Names what cannot carry `mass` (kg), and its limit: "the fingers carry 2.5 kg"; empty if all can.
[[nodiscard]] std::string overload(double mass, const GripperModel& gripper, const RobotModel& robot);

/// Draws `count` stones of a catalogue by the seed (paper §4.2: an alternating set of four of six). A stone
/// that gripper or arm cannot carry (`unfit_for_gripper`) is not drawn but named in the log.
/// @return indices, sorted; fewer than `count` where fewer are fit.
/// @throws Error (planning failed) if no stone is fit
[[nodiscard]] std::vector<StoneIndex> draw_stones(const Catalogue& catalogue, int count, int seed,
                                                  const GripperModel& gripper, const RobotModel& robot);

}  // namespace stonestack::motion

#pragma GCC visibility pop
