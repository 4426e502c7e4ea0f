#include "stonestack/hardware/cell_file.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/yaml.hpp"
#include "hardware/cell_config.hpp"
#include "hardware/constants.hpp"
#include "hardware/hold_watch.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "kinematics/gripper_file.hpp"
#include "protocol/primary_wire.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/kinematics/hand_eye.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kQuaternionSlack = 1e-3;

PoseNumbers to_numbers(const Pose& pose) {
  const Eigen::Vector3d& p = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

FieldList layout_fields(CellConfig& c) {
  return join(
      {pose_fields("T_W_R", c.T_W_R, "robot base in the world; the table is z = 0"),
       pose_fields("T_F_T", c.T_F_T, "tool tip in the flange"),
       pose_fields("T_T_C", c.T_T_C, "camera in the tool: stonestack calibrate --write"),
       {field("hand_eye", c.hand_eye, "camera in the flange, in place of T_T_C: easy_handeye file"),
        field("sensor_mass", c.sensor_mass, {0.0, 10.0}, "kg",
              "of the force sensor; FT150 0.65, FT300 0.30, the arm's own 0"),
        field("camera_mass", c.camera_mass, {0.0, 10.0}, "kg", "with bracket and cable"),
        field("obstacles", c.obstacles_text, "what the arm must not touch: a list of name, shape, T_W_O"),
        field("padding", c.padding_text, "clearance between pairs of things: a list of a, b, m")},
       {field("site.x", c.site_x, {-3.0, 3.0}, "m", "where the tower goes"),
        field("site.y", c.site_y, {-3.0, 3.0}, "m", "where the tower goes"),
        field("field.x", c.field_x, {-3.0, 3.0}, "m", "middle of the loose stones"),
        field("field.y", c.field_y, {-3.0, 3.0}, "m", "middle of the loose stones"),
        field("field.width", c.field_width, {0.05, 3.0}, "m", "along x"),
        field("field.depth", c.field_depth, {0.05, 3.0}, "m", "along y")}});
}

void require_word(const std::string& path, const std::string& name, const std::string& word,
                  std::initializer_list<const char*> allowed) {
  std::string list;
  for (const char* known : allowed) {
    if (word == known) return;
    list += concat(list.empty() ? "" : ", ", known);
  }
  throw FileError(path, concat(name, " is '", word, "'"), "write one of " + list);
}

void require_known_words(const CellConfig& c, const std::string& path) {
  require_word(path, "gripper.driver", c.gripper_driver, {"robotiq_3f", "robotiq_2f"});
  require_word(path, "gripper.link", c.gripper_link, {"urcap", "rtu"});
  require_word(path, "gripper.preset", c.gripper.preset, {"tcp2018", "tcp2014", "rtu"});
  require_word(path, "gripper.mode", c.gripper.mode, {"basic", "pinch", "wide", "scissor"});
  require_word(path, "force_torque.link", c.force_torque.link, {"serial", "ur_cap", kOwnSensorLink});
  require_word(path, "camera.driver", c.camera, {"stream", "v4l2", "realsense", "recorded"});
}

/// Force on an axis that the sensor in the flange of a robot measures, N. UR's data sheets; a robot that is
/// not named so is taken for a UR10e.
double own_sensor_range(const std::string& robot) {
  return robot == "ur3e" ? 30.0 : robot == "ur5e" ? 50.0 : robot == "ur16e" ? 160.0 : 100.0;
}

/// Without a sensor between flange and gripper: what the file leaves out is as the arm's own sensor has it.
void mount_on_flange(CellConfig& config, const std::string& robot) {
  constexpr std::size_t kZ = 2;
  config.T_F_T[kZ] -= kSensorHeight;
  config.sensor_mass = 0.0;
  config.force_torque.max_force = own_sensor_range(robot);
  config.force_torque.max_torque = kOwnSensorTorque;
}

void require_flange_axes(const CellConfig& config) {
  if (config.has_own_sensor() && config.force_torque.yaw != 0.0)
    throw FileError(config.file, concat("force_torque.yaw is ", config.force_torque.yaw, " rad with link ur"),
                    "leave it out: the arm's own sensor reports in the axes of the flange");
}

void require_usable_settings(const CellConfig& config) {
  try {
    static_cast<void>(to_layout(config));
  } catch (const InvalidArgument& problem) {
    throw FileError(config.file, problem.what(), "write a unit quaternion");
  }
  if (config.camera == "v4l2") try {
      static_cast<void>(depth_unit(config.v4l2.camera));
      static_cast<void>(to_intrinsics(config.v4l2.camera));
    } catch (const InvalidArgument& problem) {
      throw FileError(config.file, std::string("camera.v4l2: ") + problem.what(),
                      "see data/cells/lab-ur10.yaml");
    }
}

/// Both would be one too many: which of them holds?
void require_one_mount(const CellConfig& config) {
  if (config.hand_eye.empty()) return;
  bool has_pose = false;
  yaml::for_each_scalar(yaml::read_file(config.file), [&](const std::string& name, const std::string&) {
    has_pose = has_pose || name.rfind("layout.T_T_C", 0) == 0;
  });
  if (has_pose)
    throw FileError(config.file, "says layout.T_T_C and layout.hand_eye, which are the same thing",
                    "keep hand_eye, the camera in the flange, or T_T_C, the camera in the tool");
}

/// Beside the cell file, unless the path is a whole one.
std::string path_beside(const std::string& cell_file, const std::string& name) {
  const char* home = std::getenv("HOME");
  if (name.rfind("~/", 0) == 0 && home != nullptr) return home + name.substr(1);
  return std::filesystem::path(cell_file).parent_path() / name;
}

/// The driver speaks to one kind of gripper: the wrong one would misread every register.
void require_driver_of_gripper(const CellConfig& config, const std::string& path) {
  const GripperFile figures = read_gripper_file(config.gripper_name);
  const std::string fits = figures.against == 1 ? "robotiq_2f" : "robotiq_3f";
  if (config.gripper_driver != fits)
    throw FileError(path,
                    concat("gripper.driver is ", config.gripper_driver, ", the gripper is ", figures.name),
                    "write gripper.driver: " + fits + ", or leave it out");
}

/// ROS has frames at flange and camera that are turned against F and C.
void warn_of_frames(const std::string& path, const EasyHandEye& calibration) {
  const auto warn = [&](const char* key, const char* wanted, const std::string& end) {
    for (const auto& p : calibration.parameters)
      if (p.key == key && !p.value.empty() && p.value.find(end) == std::string::npos)
        log_warning(concat(path, ": ", key, " is ", p.value, ", which is taken for ", wanted));
  };
  warn("robot_effector_frame", "the flange as the controller has it (tool0)", "tool0");
  warn("tracking_base_frame", "the depth image's optical frame (z forward, x right)", "optical");
}

std::unique_ptr<DepthCamera> open_camera(const CellConfig& config) {
  if (config.camera == "stream") return std::make_unique<StreamCamera>(config.stream);
  if (config.camera == "v4l2") return std::make_unique<V4l2Camera>(config.v4l2);
  if (config.camera == "realsense") return std::make_unique<RealsenseCamera>(config.realsense);
  require(config.camera == "recorded", "camera.driver must be stream, v4l2, realsense or recorded, got '",
          config.camera, "'");
  return std::make_unique<RecordedCamera>(config.recorded);
}

}  // namespace

CellConfig::CellConfig() {
  const CellLayout layout;
  T_F_T = to_numbers(layout.T_F_T);
  T_T_C = to_numbers(layout.T_T_C);
  sensor_mass = layout.sensor_mass;
  camera_mass = layout.camera_mass;
  site_x = layout.site.x();
  site_y = layout.site.y();
  field_x = layout.field_centre.x();
  field_y = layout.field_centre.y();
  field_width = layout.field_size.x();
  field_depth = layout.field_size.y();
}

CellConfig::CellConfig(const std::string& name) : CellConfig() {
  if (name == gripper_name) return;
  const GripperFile figures = read_gripper_file(name);
  const CellLayout layout = with_gripper({}, name);
  gripper_name = name;
  T_F_T = to_numbers(layout.T_F_T);
  T_T_C = to_numbers(layout.T_T_C);
  gripper.max_opening = figures.max_opening;
  gripper.open_count = figures.open_count;
  gripper.closed_count = figures.closed_count;
  if (figures.against != 1) return;
  gripper_driver = "robotiq_2f";
  gripper.modbus.port = kUrCapPort;
}

FieldList fields(CellConfig& c) {
  return join(
      {{user(field("robot", c.robot, "ur3 to ur16e, or a URDF or robot file, beside the cell file")),
        user(field("hand", c.gripper_name,
                   "gripper: robotiq-3f, robotiq-2f-85, robotiq-2f-140, robotiq-hand-e, or a YAML"))},
       nest("arm", fields(c.arm)),
       nest("gripper",
            {field("driver", c.gripper_driver, "robotiq_3f, or robotiq_2f for 2F-85, 2F-140 and Hand-E"),
             field("link", c.gripper_link, "of robotiq_2f: urcap (port 63352) or rtu (serial line)")}),
       nest("gripper", fields(c.gripper)),
       nest("force_torque", fields(c.force_torque)),
       {user(field("camera.driver", c.camera, "stream, v4l2, realsense or recorded"))},
       nest("camera.stream", fields(c.stream)),
       nest("camera.v4l2", fields(c.v4l2)),
       nest("camera.realsense", fields(c.realsense)),
       nest("camera.recorded", fields(c.recorded)),
       nest("layout", user(layout_fields(c))),
       nest("limits", fields(c.limits))});
}

FieldList pose_fields(const std::string& name, PoseNumbers& n, const std::string& source) {
  FieldList list;
  const char* keys[] = {"x", "y", "z", "qx", "qy", "qz", "qw"};
  for (std::size_t i = 0; i < n.size(); ++i)
    list.push_back(i < 3 ? field(name + "." + keys[i], n[i], {-10.0, 10.0}, "m", source)
                         : field(name + "." + keys[i], n[i], {-1.0, 1.0}, "", source));
  return list;
}

Pose to_pose(const PoseNumbers& n, const std::string& name) {
  const Eigen::Quaterniond q(n[6], n[3], n[4], n[5]);
  require(std::abs(q.norm() - 1.0) < kQuaternionSlack, name, ": (qx, qy, qz, qw) has the length ", q.norm(),
          "; a rotation has 1");
  return make_pose({n[0], n[1], n[2]}, q.normalized());
}

void read_hand_eye(CellConfig& config) {
  config.T_F_C.reset();
  if (config.hand_eye.empty()) return;
  const std::string path = path_beside(config.file, config.hand_eye);
  const EasyHandEye calibration = read_easy_handeye(path);
  if (calibration.mount != CameraMount::kOnHand)
    throw FileError(path,
                    "is the calibration of a camera beside the arm (eye_on_hand: false, or eye_on_base)",
                    "layout.hand_eye needs one of the camera on the gripper");
  warn_of_frames(path, calibration);
  config.T_F_C = calibration.T_A_C;
}

CellLayout to_layout(const CellConfig& c) {
  CellLayout layout;
  layout.T_W_R = to_pose(c.T_W_R, "layout.T_W_R");
  layout.T_F_T = to_pose(c.T_F_T, "layout.T_F_T");
  layout.T_T_C = c.T_F_C ? layout.T_F_T.inverse() * *c.T_F_C : to_pose(c.T_T_C, "layout.T_T_C");
  layout.gripper = c.gripper_name;
  layout.sensor_mass = c.sensor_mass;
  layout.camera_mass = c.camera_mass;
  layout.obstacles = c.obstacles;
  layout.paddings = c.paddings;
  layout.site = {c.site_x, c.site_y};
  layout.field_centre = {c.field_x, c.field_y};
  layout.field_size = {c.field_width, c.field_depth};
  return layout;
}

RobotModel read_cell_robot(const CellConfig& config) {
  const CellLayout layout = to_layout(config);
  return limit_robot(read_robot(config.robot), config.limits, layout.T_W_R, layout.T_F_T,
                     config.file.empty() ? "the cell" : config.file);
}

CellConfig read_cell_file(const std::string& path, const FieldList& others) {
  CellConfig config;
  read_fields(fields(config), path, others);
  if (config.gripper_name != CellConfig{}.gripper_name ||
      config.has_own_sensor()) {  // what the file does not give is as gripper and sensor have it
    const std::string name =
        is_gripper_path(config.gripper_name) ? path_beside(path, config.gripper_name) : config.gripper_name;
    const bool on_flange = config.has_own_sensor();
    const std::string robot = config.robot;
    config = CellConfig(name);
    if (on_flange) mount_on_flange(config, robot);
    read_fields(fields(config), path, others);
    config.gripper_name = name;
  }
  config.file = path;
  if (std::error_code none; std::filesystem::is_regular_file(path_beside(path, config.robot), none))
    config.robot = path_beside(path, config.robot);
  config.obstacles = parse_obstacles(config.obstacles_text, path, "layout.obstacles");
  std::vector<std::string> names;
  for (const Obstacle& obstacle : config.obstacles) names.push_back(obstacle.name);
  config.paddings = parse_pair_paddings(config.padding_text, path, "layout.padding", names);
  require_known_words(config, path);
  require_driver_of_gripper(config, path);
  require_flange_axes(config);
  require_one_mount(config);
  read_hand_eye(config);
  require_usable_settings(config);
  static_cast<void>(read_cell_robot(config));
  return config;
}

void require_arm_address(const CellConfig& config) {
  if (config.arm.address.empty())
    throw FileError(config.file.empty() ? "the cell" : config.file, "arm.address is missing",
                    "write the address of the robot's controller, as `arm: {address: 192.168.1.10}`");
}

TwoFingerOptions two_finger_options(const CellConfig& config) {
  const GripperFile figures = read_gripper_file(config.gripper_name);
  const ThreeFingerOptions& own = config.gripper;
  TwoFingerOptions o;
  o.link = config.gripper_link;
  o.modbus = own.modbus;
  o.modbus.unit = own.unit;
  o.max_opening = own.max_opening;
  o.open_count = own.open_count;
  o.closed_count = own.closed_count;
  o.min_force = figures.min_force;
  o.max_force = figures.max_force;
  o.min_speed = figures.min_speed;
  o.max_speed = figures.max_speed;
  o.activation_timeout = own.activation_timeout;
  o.echo_timeout = own.echo_timeout;
  o.move_margin = own.move_margin;
  o.poll = own.poll;
  return o;
}

std::unique_ptr<RobotiqGripper> make_gripper(const CellConfig& config) {
  if (config.gripper_driver == "robotiq_2f")
    return std::make_unique<TwoFingerGripper>(two_finger_options(config));
  return std::make_unique<ThreeFingerGripper>(config.gripper);
}

std::unique_ptr<ForceTorqueSensor> make_force_torque(const CellConfig& config) {
  if (config.has_own_sensor()) return std::make_unique<UrForceTorque>(config.arm, config.force_torque);
  return std::make_unique<RobotiqFtSensor>(config.force_torque);
}

std::unique_ptr<DepthCamera> make_camera(const CellConfig& config) {
  try {
    return open_camera(config);
  } catch (const InvalidArgument& problem) {
    if (config.file.empty()) throw;
    throw FileError(config.file, concat("camera.", config.camera, ": ", problem.what()),
                    "`stonestack config cell --expert` lists all settings");
  }
}

struct HardwareCell::Devices {
  CellLayout layout;
  std::unique_ptr<Clock> clock = make_steady_clock();
  RobotModel robot;
  std::unique_ptr<ForceTorqueSensor> force_torque;
  UrArm arm;
  std::unique_ptr<RobotiqGripper> gripper;
  HoldWatch watched_arm;
  std::unique_ptr<DepthCamera> camera;

  explicit Devices(const CellConfig& config)
      : layout(to_layout(config)),
        robot(read_cell_robot(config)),
        force_torque(make_force_torque(config)),
        arm(robot, config.arm, layout.T_W_R, layout.T_F_T, force_torque.get()),
        gripper(make_gripper(config)),
        watched_arm(arm, *gripper),
        camera(make_camera(config)) {}
};

HardwareCell::HardwareCell(const CellConfig& config) {
  require_arm_address(config);
  if (!config.arm.serial.empty())
    DashboardClient({config.arm.address, config.arm.dashboard_port}).require_serial(config.arm.serial);
  devices_ = std::make_unique<Devices>(config);
}

HardwareCell::HardwareCell(const std::string& path) : HardwareCell(read_cell_file(path)) {}

HardwareCell::~HardwareCell() = default;

Cell HardwareCell::cell() {
  auto& d = *devices_;
  return {d.watched_arm, *d.gripper, *d.force_torque, *d.camera, *d.clock, d.layout};
}

bool HardwareCell::activates_gripper() {
  return !devices_->gripper->is_active();
}

void HardwareCell::activate_gripper() {
  if (activates_gripper()) devices_->gripper->activate();
}

std::string HardwareCell::safety_checksum() const {
  const auto checksum = devices_->arm.safety_checksum();
  return checksum ? checksum_text(*checksum) : std::string();
}

}  // namespace stonestack::hardware
