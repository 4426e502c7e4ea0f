#include <algorithm>

#include "stonestack/core/error.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {
namespace {

SimulationOptions no_errors() {
  SimulationOptions o;
  o.friction_spread = 0.0;
  o.sensor_noise = false;
  o.hand_eye_translation = o.hand_eye_rotation = 0.0;
  o.arm_repeatability = o.arm_residual = 0.0;
  o.mass_error = o.com_error = 0.0;
  return o;
}

/// Every error of a lab at once. Hand-eye, repeatability and wrist noise are those of the default cell.
SimulationOptions lab() {
  SimulationOptions o;
  o.friction = 0.475;  // 0.3 to 0.65
  o.friction_spread = 0.175;
  o.sensor = "f200";
  o.lens_focal = 0.002;
  o.lens_centre = 1.0;
  o.lens_distortion = 1.0;
  o.arm_residual = 0.0;  // the links' errors take its place
  o.arm_kinematics = 0.00075;
  o.arm_backlash = 0.0002;
  o.arm_compliance = 3e-5;
  o.base_translation = 0.002;
  o.base_rotation = 0.00349066;  // 0.2 deg
  o.table_height = 0.002;
  o.table_tilt = 0.00523599;  // 0.3 deg
  o.table_unevenness = 0.0005;
  o.force_delay = 0.030;
  o.force_drift = 0.02;
  o.gripper_inertia = true;
  o.mass_error = 0.03;
  o.com_error = 0.003;
  o.scan_error = 0.0003;
  o.scan_roughness = 0.0001;
  o.pad_friction_spread = 0.15;
  o.pad_stiffness_spread = 2.0;
  o.linkage = "three_finger";
  o.clearance = 0.005;
  o.foreign_objects = 2;
  return o;
}

SimulationOptions hard() {
  SimulationOptions o = lab();
  for (double* error :
       {&o.friction_spread, &o.sensor_scale,         &o.lens_focal,          &o.lens_centre,
        &o.lens_distortion, &o.hand_eye_translation, &o.hand_eye_rotation,   &o.arm_repeatability,
        &o.arm_kinematics,  &o.arm_backlash,         &o.arm_compliance,      &o.base_translation,
        &o.base_rotation,   &o.table_height,         &o.table_tilt,          &o.table_unevenness,
        &o.force_delay,     &o.force_drift,          &o.mass_error,          &o.com_error,
        &o.scan_error,      &o.scan_roughness,       &o.pad_friction_spread, &o.pad_stiffness_spread})
    *error *= 2.0;
  o.foreign_objects *= 2;
  return o;
}

}  // namespace

FieldList fields(SimulationOptions& o) {
  return {
      user(field("seed", o.seed, {0, 2147483647.0}, "", "seed of the simulated world")),
      user(field("cell", o.cell,
                 "named set of errors, which other options override: ideal (none), mild, lab (all at once), "
                 "paper (lab with friction 0.1 to 0.2) or hard (lab's doubled)")),
      field("engine", o.engine, "physics of the true world: bullet or ode; the planner's is Bullet"),
      user(
          field("friction", o.friction, {0.05, 2.0}, "", "true coefficient between stones, mean over pairs")),
      field("friction_spread", o.friction_spread, {0.0, 1.0}, "",
            "half width of the uniform draw for each pair"),
      user(field("sensor", o.sensor, "depth camera: a name of data/sensors, a file of that form, or ideal")),
      field("sensor_noise", o.sensor_noise, "false: camera and force sensor are exact"),
      field("sensor_scale", o.sensor_scale, {0.0, 10.0}, "",
            "factor on the camera's errors and the force sensor's noise"),
      field("lens_focal", o.lens_focal, {0.0, 0.1}, "", "error of the reported focal length, as a share"),
      field("lens_centre", o.lens_centre, {0.0, 20.0}, "px", "error of the reported centre of the image"),
      field("lens_distortion", o.lens_distortion, {0.0, 20.0}, "px",
            "radial distortion left over in a corner of the image"),
      field("hand_eye_translation", o.hand_eye_translation, {0.0, 0.05}, "m", "error of the camera's mount"),
      field("hand_eye_rotation", o.hand_eye_rotation, {0.0, 0.2}, "rad", "error of the camera's mount"),
      field("arm_repeatability", o.arm_repeatability, {0.0, 0.01}, "m",
            "of the tool tip, root mean square; UR10: 0.1 mm"),
      field("arm_residual", o.arm_residual, {0.0, 0.05}, "m",
            "error of the tool tip by joint angles that are off, root mean square"),
      field("arm_kinematics", o.arm_kinematics, {0.0, 0.05}, "m",
            "error of the tool tip by links unlike their model, root mean square over the cell"),
      field("arm_backlash", o.arm_backlash, {0.0, 0.01}, "rad",
            "lost motion of each joint when it turns back"),
      field("arm_compliance", o.arm_compliance, {0.0, 0.001}, "m/N",
            "how far the tool tip over the field gives way to 1 N from above"),
      field("base_translation", o.base_translation, {0.0, 0.05}, "m", "robot base beside its stated place"),
      field("base_rotation", o.base_rotation, {0.0, 0.1}, "rad", "robot base against its stated axes"),
      field("table_height", o.table_height, {0.0, 0.05}, "m", "table above or below its stated height"),
      field("table_tilt", o.table_tilt, {0.0, 0.1}, "rad", "of the table"),
      field("table_unevenness", o.table_unevenness, {0.0, 0.01}, "m",
            "of the table about its plane, at most; waves of 0.3 to 0.8 m"),
      field("force_delay", o.force_delay, {0.0, 0.2}, "s", "age of the force sensor's readings"),
      field("force_drift", o.force_drift, {0.0, 1.0}, "N/s", "of the force sensor's zero, at most"),
      field("gripper_inertia", o.gripper_inertia, "true: the force sensor feels the gripper accelerate"),
      field("mass_error", o.mass_error, {0.0, 0.5}, "", "of the stones' masses, one sigma as a share"),
      field("com_error", o.com_error, {0.0, 0.02}, "m", "of the stones' centres of mass at most"),
      user(field("scan_error", o.scan_error, {0.0, 0.002}, "m",
                 "of the stones' surfaces against their scans in waves of 20 mm, root mean square")),
      field("scan_roughness", o.scan_roughness, {0.0, 0.001}, "m", "likewise in waves of 3 mm"),
      field("pad_friction", o.pad_friction, {0.05, 2.0}, "", "rubber on stone, mean over stones"),
      field("pad_friction_spread", o.pad_friction_spread, {0.0, 1.0}, "",
            "half width of the uniform draw for each stone"),
      field("pad_stiffness", o.pad_stiffness, {1e6, 1e10}, "N/m^3", "of the pads; 5 mm of soft rubber"),
      field("pad_stiffness_spread", o.pad_stiffness_spread, {1.0, 10.0}, "",
            "factor by which the pads of a run are stiffer or softer, at most"),
      field("linkage", o.linkage,
            "true path of the finger tips: parallel (flat jaws) or three_finger (on an arc, as phalanges "
            "turn)"),
      field("regrip", o.regrip, "true: fingers close further when the held stone yields (rGTO stays set)"),
      field("clearance", o.clearance, {0.0, 0.3}, "m",
            "between loose stones at the start; a finger and a half by default"),
      field("foreign_objects", o.foreign_objects, {0, 10}, "",
            "boxes and cylinders among the stones that no catalogue has"),
  };
}

SimulationOptions options_of_cell(const std::string& cell) {
  SimulationOptions options;
  if (cell == "ideal")
    options = no_errors();
  else if (cell == "lab" || cell == "paper")
    options = lab();
  else if (cell == "hard")
    options = hard();
  else
    require(cell == "mild", "there are the cells ideal, mild, lab, paper and hard; got '", cell, "'");
  if (cell == "paper") {
    options.friction = 0.15;
    options.friction_spread = 0.05;
  }
  options.cell = cell;
  return options;
}

std::vector<std::string> changed_in_cell(const SimulationOptions& options) {
  SimulationOptions given = options, named = options_of_cell(options.cell);
  named.seed = given.seed;
  const FieldList now = fields(given), before = fields(named);
  std::vector<std::string> changed;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (field_text(now[i]) != field_text(before[i]))
      changed.push_back(now[i].name + "=" + field_text(now[i]));
  return changed;
}

}  // namespace stonestack::simulation
