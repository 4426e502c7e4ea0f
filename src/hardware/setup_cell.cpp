#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/constants.hpp"
#include "hardware/cell_config.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "hardware/ur/primary_client.hpp"
#include "hardware/ur/rtde_client.hpp"
#include "kinematics/calibration.hpp"
#include "kinematics/gripper_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

using Vector6 = std::array<double, 6>;
using Vector3 = std::array<double, 3>;

constexpr double kStateTime = 3.0;       // s: a controller sends ten states a second
constexpr double kPayloadAgrees = 0.25;  // kg between what is mounted and what the controller counts on
constexpr double kNominal = 1e-6;        // m and rad: a table within it is the nominal one

const std::vector<std::string> kGrippers{"robotiq-3f", "robotiq-2f-85", "robotiq-2f-140", "robotiq-hand-e"};

/// Whether the gripper has a network socket of its own; the others are reached through the arm's.
bool has_own_address(const std::string& gripper) {
  return gripper == kGrippers.front();
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

[[noreturn]] void refuse_setup(const std::string& problem) {
  throw Error(problem, ExitCode::kUsage);
}

void ask_rtde(const CellConfig& config, ControllerDescription& found) {
  const auto recipe = [](const UrVersion&) {
    return RtdeRecipe{{"actual_q"}, {"payload", "payload_cog", "tcp_offset"}, {}};
  };
  const RtdeClient rtde({config.arm.address, config.arm.rtde_port}, recipe, config.arm.rtde);
  const RtdeSample sample = rtde.sample();
  if (sample.has("payload")) found.payload = sample.get<double>("payload");
  if (sample.has("payload_cog"))
    found.p_F_payload = Eigen::Map<const Eigen::Vector3d>(sample.get<Vector3>("payload_cog").data());
  if (sample.has("tcp_offset"))
    found.p_F_tip = Eigen::Map<const Eigen::Vector3d>(sample.get<Vector6>("tcp_offset").data());
}

void ask_primary(const CellConfig& config, ControllerDescription& found) {
  PrimaryOptions options;
  options.ports = {config.arm.primary_port, config.arm.secondary_port};
  const PrimaryClient primary(config.arm.address, options);
  const auto kinematics = primary.wait_for_kinematics(Deadline::in(kStateTime));
  if (const auto checksum = primary.wait_for_safety_checksum(Deadline::in(kStateTime)))
    found.safety_checksum = checksum_text(*checksum);
  if (!kinematics) return;
  found.dh.emplace();
  for (std::size_t j = 0; j < 6; ++j)
    (*found.dh)[j] = {kinematics->theta[j], kinematics->d[j], kinematics->a[j], kinematics->alpha[j]};
}

/// "UR10" of an e-Series controller is a ur10e.
std::string robot_of(const CellSetup& setup, const ControllerDescription& controller) {
  const std::vector<std::string> known = kinematics::robot_names();
  std::string name = setup.robot;
  if (name.empty()) {
    for (const char c : controller.model)
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (name.empty())
      refuse_setup(concat("PolyScope ", controller.polyscope,
                          " does not say which arm it has: give it with --robot (", listed(known), ")"));
    if (controller.e_series && name.back() != 'e') name += 'e';
  }
  if (std::find(known.begin(), known.end(), name) == known.end())
    refuse_setup(concat("the arm is a '", name, "', which is unknown; known are ", listed(known),
                        ": give the one whose kinematics it has with --robot, or write `robot: FILE.urdf`"));
  return name;
}

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

std::string robot_text(const std::string& robot, const ControllerDescription& controller) {
  std::string text = concat("# Factory calibration of the arm, as its controller (PolyScope ",
                            controller.polyscope, ") has it: m and rad.\nrobot: ", robot, "\ndh:\n");
  for (std::size_t j = 0; j < 6; ++j) {
    const auto& row = (*controller.dh)[j];
    text += concat("  joint_", j + 1, ": {theta: ", number(row[0]), ", d: ", number(row[1]),
                   ", a: ", number(row[2]), ", alpha: ", number(row[3]), "}\n");
  }
  return text;
}

/// True for text that can stand in a file between quotes.
bool is_serial(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
}

bool is_nominal(const RobotModel& robot, const std::array<std::array<double, 4>, 6>& dh) {
  const std::array<kinematics::DhRow, 6> drawn = kinematics::nominal_calibration(robot).dh;
  for (std::size_t j = 0; j < 6; ++j) {
    const std::array<double, 4> row{drawn[j].theta, drawn[j].d, drawn[j].a, drawn[j].alpha};
    for (std::size_t k = 0; k < 4; ++k)
      if (std::abs(row[k] - dh[j][k]) > kNominal) return false;
  }
  return true;
}

/// The text of a cell file. What the controller does not know is marked.
std::string cell_text(const CellSetup& setup, const ControllerDescription& controller,
                      const std::string& robot) {
  std::string text = concat("# Cell of the arm at ", setup.arm, " (PolyScope ", controller.polyscope,
                            "), written by `stonestack setup`. Lines with \"check\" are\n"
                            "# not known to the controller: look at each, then `stonestack doctor --cell "
                            "FILE`. Nothing moves without "
                            "--execute.\nrobot: ",
                            robot, "\nhand: ", setup.gripper, "\narm:\n  address: ", setup.arm, "\n");
  if (is_serial(controller.serial))
    text += concat("  serial: \"", controller.serial, "\"  # of the arm; nothing moves another one\n");
  if (!controller.safety_checksum.empty())
    text += concat("  safety_checksum: ", controller.safety_checksum,
                   "  # of the safety configuration; nothing moves with another\n");
  text += "gripper:\n";
  if (has_own_address(setup.gripper))
    text +=
        concat("  preset: tcp2018      # check: tcp2014 for older units, rtu for a serial line\n  address: ",
               setup.gripper_address, "\n");
  else
    text += concat("  link: urcap          # check: rtu for a serial line of this machine\n  address: ",
                   setup.arm, "\n");
  text += controller.e_series ? std::string("force_torque:\n  link: ur\n")
                              : concat(
                                    "force_torque:\n  link: ur_cap         # check: serial for one at this "
                                    "machine\n  address: ",
                                    setup.arm, "\n");
  text +=
      "camera:\n  driver: v4l2         # check: realsense, stream, recorded\n  v4l2:\n"
      "    device: /dev/video2  # check\n    depth_scale: 8000    # check; SR300: counts a metre\n"
      "    width: 640\n    height: 480\n"
      "    fx: 475.0            # check: write your own; these are of no particular camera\n"
      "    fy: 475.0\n    cx: 320.0\n    cy: 240.0\n"
      "layout:\n"
      "  T_T_C: {x: 0.0, y: 0.11, z: -0.17, qx: 0.0871557, qy: 0.0, qz: 0.0, qw: 0.9961947}  # check: "
      "stonestack "
      "calibrate --write\n"
      "  site: {x: 0.70, y: 0.28}                                # check: where the tower stands, m in the "
      "base\n"
      "  field: {x: 0.70, y: -0.18, width: 0.40, depth: 0.50}    # check: where the stones lie\n";
  if (!controller.e_series)
    text += concat("  sensor_mass: ", CellLayout{}.sensor_mass, "    # check: kg, FT150; an FT300: 0.30\n");
  text += concat(
      "  camera_mass: ", CellLayout{}.camera_mass,
      "     # check: kg, with bracket and cable\n"
      "  # obstacles:         # check: what the arm must not touch beside table and stones, m in the world\n"
      "  #   - {name: wall, box: {x: 0.02, y: 2, z: 1.5}, T_W_O: {x: -0.4, y: 0, z: 0.75, qx: 0, qy: 0, "
      "qz: 0, qw: 1}}\n"
      "limits:\n"
      "  tool_speed: 0.25     # m/s\n"
      "  workspace: {x: [0.2, 1.1], y: [-0.7, 0.7], z: [-0.02, 1.2]}   # check: the tool's tip, m in the "
      "world\n"
      "  fence: {x: [-0.5, 1.3], y: [-0.9, 0.9], z: [-0.1, 1.6]}       # check: the whole arm and gripper\n");
  return text;
}

void note_payload(const CellConfig& cell, const ControllerDescription& controller, NewCell& made) {
  if (!controller.payload) return;
  const double mounted =
      kinematics::read_gripper_file(cell.gripper_name).mass + cell.sensor_mass + cell.camera_mass;
  if (std::abs(*controller.payload - mounted) > kPayloadAgrees)
    made.notes.push_back(concat("the installation on the pendant counts on ", *controller.payload,
                                " kg at the flange, gripper, sensor and camera of this cell weigh about ",
                                mounted, " kg: weigh them and set the payload there"));
}

/// Writes `text` beside `path`, reads it as what it is, and only then gives it its name. Returns what was
/// read.
template <class Read>
auto write_if_read(const std::string& path, const std::string& text, const Read& read) {
  const std::filesystem::path at(path);
  const std::string trial =
      (at.parent_path() / (at.stem().string() + ".new" + at.extension().string())).string();
  require_writable(path);
  write_file(trial, text);
  const std::shared_ptr<void> removes(nullptr, [&](void*) {
    std::error_code ignored;
    std::filesystem::remove(trial, ignored);
  });
  auto found = read(trial);
  write_file(path, text);
  return found;
}

/// Beside the cell file.
std::string robot_file_of(const std::string& cell_file) {
  const std::filesystem::path path(cell_file);
  return (path.parent_path() / (path.stem().string() + "-robot.yaml")).string();
}

/// Letters, digits and what else names and addresses have, so that a file keeps its form.
void require_address(const std::string& address) {
  const bool sound = std::all_of(address.begin(), address.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string(".-_:%").find(static_cast<char>(c)) != std::string::npos;
  });
  if (!sound)
    refuse_setup(concat("'", address, "' is no address or name of a device, as 192.168.1.10 or ur10.local"));
}

}  // namespace

ControllerDescription describe_controller(const CellConfig& config) {
  require_arm_address(config);
  ControllerDescription found;
  DashboardClient dashboard({config.arm.address, config.arm.dashboard_port});
  const UrVersion version = dashboard.version();
  found.polyscope = to_string(version);
  found.e_series = !version.is_cb3();
  found.model = dashboard.robot_model().value_or("");
  found.serial = dashboard.serial_number().value_or("");
  found.state = {dashboard.robot_mode(), dashboard.safety(), dashboard.is_program_running()};
  found.remote_control = dashboard.is_in_remote_control();
  ask_rtde(config, found);
  ask_primary(config, found);
  return found;
}

ControllerDescription describe_controller(const std::string& arm) {
  CellConfig config;
  config.arm.address = arm;
  return describe_controller(config);
}

void require_sound(const CellSetup& setup) {
  const std::string ending = std::filesystem::path(setup.path).extension().string();
  if (ending != ".yaml" && ending != ".yml")
    refuse_setup(concat("'", setup.path, "' is no name for a cell file: it ends with .yaml"));
  if (setup.arm.empty()) refuse_setup("the robot's address is missing: give it with --address HOST");
  if (std::find(kGrippers.begin(), kGrippers.end(), setup.gripper) == kGrippers.end())
    refuse_setup(concat("the gripper '", setup.gripper, "' is unknown; known are ", listed(kGrippers),
                        ". For one of your own write `hand: FILE.yaml` into the cell file afterwards"));
  if (has_own_address(setup.gripper) && setup.gripper_address.empty())
    refuse_setup(concat("a ", setup.gripper,
                        " has a network address of its own: give it with --gripper-address HOST"));
  require_address(setup.arm);
  require_address(setup.gripper_address);
  for (const std::string& file : {setup.path, robot_file_of(setup.path)})
    if (!setup.replace && std::filesystem::exists(file))
      throw FileError(file, "is there already", "take another name, or give --force to replace it");
}

NewCell write_new_cell(const CellSetup& setup, const ControllerDescription& controller) {
  require_sound(setup);
  NewCell made;
  made.path = setup.path;
  made.robot = robot_of(setup, controller);
  std::string robot = made.robot;
  if (!controller.dh) {
    made.notes.emplace_back(
        "the controller did not say its kinematics: the arm is taken for the nominal one, which is 1 mm off "
        "or more");
  } else if (const RobotModel nominal = read_robot(made.robot); !is_nominal(nominal, *controller.dh)) {
    made.robot_file = robot_file_of(setup.path);
    robot = std::filesystem::path(made.robot_file).filename().string();
    const RobotModel measured =
        write_if_read(made.robot_file, robot_text(made.robot, controller), read_robot);
    const Joints stretched = Joints::Zero();
    made.calibration =
        (forward(measured, stretched).translation() - forward(nominal, stretched).translation()).norm();
  }
  const CellConfig cell = write_if_read(setup.path, cell_text(setup, controller, robot),
                                        [](const std::string& trial) { return read_cell_file(trial); });
  note_payload(cell, controller, made);
  if (controller.safety_checksum.empty())
    made.notes.emplace_back(
        "the controller says no checksum of its safety configuration: that it stays as it is cannot be "
        "checked");
  if (controller.remote_control == false)
    made.notes.emplace_back(
        "the controller is in local control: switch to Remote on the pendant before a run");
  return made;
}

std::string new_cell_json(const NewCell& cell, const ControllerDescription& controller) {
  nlohmann::json json{{"schema", "stonestack.setup/1"},
                      {"cell", cell.path},
                      {"robot", cell.robot},
                      {"polyscope", controller.polyscope},
                      {"robot_mode", controller.state.robot_mode},
                      {"safety", controller.state.safety},
                      {"notes", cell.notes}};
  if (!cell.robot_file.empty()) {
    json["robot_file"] = cell.robot_file;
    json["calibration_m"] = cell.calibration;
  }
  if (!controller.serial.empty()) json["serial"] = controller.serial;
  if (!controller.safety_checksum.empty()) json["safety_checksum"] = controller.safety_checksum;
  if (controller.payload) json["payload_kg"] = *controller.payload;
  if (controller.p_F_payload)
    json["payload_centre_m"] = {controller.p_F_payload->x(), controller.p_F_payload->y(),
                                controller.p_F_payload->z()};
  if (controller.p_F_tip)
    json["tool_centre_point_m"] = {controller.p_F_tip->x(), controller.p_F_tip->y(), controller.p_F_tip->z()};
  return json.dump(2) + "\n";
}

}  // namespace stonestack::hardware
