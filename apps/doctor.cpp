#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "cell_input.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "hardware/ur/ur_status.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/socket.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/hardware/ur/dashboard_client.hpp"
#include "stonestack/hardware/ur/primary_client.hpp"
#include "stonestack/kinematics/mount_reading.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::apps {
namespace {

constexpr std::uint32_t kPolyScopeX = 10;
constexpr double kListen = 1.0;  // s to RTDE
constexpr double kHello = 2.0;   // s until a controller has said who it is; it sends a state every 0.1 s

struct DoctorCommand {
  CommonOptions common;
  std::string cell;
  int frames = 2;
};

/// Finding of a step: `to_do` is nothing wrong, but something to know or to do before a run.
struct Check {
  Check(std::string all_well) : text(std::move(all_well)) {}  // NOLINT: most looks find only that
  Check(std::string found, bool something_to_do) : text(std::move(found)), to_do(something_to_do) {}
  std::string text;
  bool to_do = false;
};

/// One thing that was looked at.
struct Finding {
  std::string device;
  std::string step;
  bool good = false;
  bool to_do = false;
  std::string text;  ///< what was found, or what is wrong and what to do
};

/// Runs the steps in order and keeps what each found; nothing here moves anything.
class Examination {
 public:
  /// `check_camera` returns what it found, or throws with what is wrong. False when it threw.
  bool step(const std::string& device, const std::string& step, const std::function<Check()>& check_camera) {
    throw_if_interrupted();
    Finding finding{device, step, true, false, ""};
    try {
      const Check found = check_camera();
      finding.text = found.text;
      finding.to_do = found.to_do;
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& problem) {
      finding.good = false;
      finding.text = problem.what();
    }
    std::cerr << (!finding.good   ? "FAIL  "
                  : finding.to_do ? "note  "
                                  : "ok    ")
              << device << ", " << step << ": " << finding.text << '\n';
    findings_.push_back(finding);
    return finding.good;
  }
  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }

 private:
  std::vector<Finding> findings_;
};

void refuse(const std::string& device, const std::string& problem, const std::string& remedy) {
  throw DeviceError(device, problem, remedy);
}

std::string ask_dashboard(const CellConfig& cell) {
  DashboardClient dashboard({cell.arm.address, cell.arm.dashboard_port});
  const UrVersion version = dashboard.version();
  const std::string mode = dashboard.robot_mode(), safety = dashboard.safety();
  const auto remote = dashboard.is_in_remote_control();
  const std::string name = "UR controller at " + cell.arm.address;
  if (version.major >= kPolyScopeX)
    refuse(name, "PolyScope X is not supported", "use a CB3 or an e-Series controller");
  if (remote && !*remote)
    refuse(name, "is in local mode and ignores programs from outside",
           "switch to Remote Control on the pendant");
  if (safety != "NORMAL" && safety != "REDUCED")
    refuse(name, "safety is " + safety, "look at the cell, then clear the stop on the pendant");
  if (mode != "RUNNING")
    refuse(name, "robot mode is " + mode, "switch on and release the brakes on the pendant");
  return concat("PolyScope ", to_string(version), ", robot ", mode, ", safety ", safety,
                remote ? ", remote control" : "");
}

std::string hear_primary(const CellConfig& cell) {
  PrimaryOptions options;
  options.ports = {cell.arm.primary_port, cell.arm.secondary_port, cell.arm.realtime_port};
  std::erase(options.ports, 0);  // left out
  const PrimaryClient primary(cell.arm.address, options);
  primary.wait_until_heard(Deadline::in(kHello));
  return concat("scripts go to port ", primary.port());
}

/// Answers of the devices, for comparing them with each other.
struct DeviceReports {
  UrVersion version;
  std::optional<Joints> q;          ///< of an arm that answers
  std::optional<DepthImage> image;  ///< taken now: not of a recording
};

/// For a while, so that a stream that breaks again and again is found; with all that a run reads and writes.
Check listen_rtde(const CellConfig& cell, DeviceReports& reports) {
  const auto recipe = [&, served = served_recipe(cell.arm.address)](const UrVersion& reported) {
    reports.version = reported;
    return served(reported);
  };
  const RtdeClient rtde({cell.arm.address, cell.arm.rtde_port}, recipe, cell.arm.rtde);
  for (const Stopwatch watch; watch.seconds() < kListen;) {
    throw_if_interrupted();
    (void)rtde.wait_for_next(Deadline::in(kListen));
  }
  const RtdeSample sample = rtde.sample();
  if (const int lost = rtde.counts().sessions - 1; lost > 0)
    refuse(concat("UR RTDE at ", cell.arm.address, ":", cell.arm.rtde_port),
           concat("the stream broke ", lost, " times within ", kListen, " s"),
           "look at cable and switch, and at the controller's log");
  const UrStatus status = read_status(sample, first_register(rtde.version()));
  reports.q = status.q;
  std::string text = concat("protocol ", rtde.protocol(), ", controller time ", sample.device_time(),
                            " s, joints ", status.q.transpose(), " rad");
  for (const std::string& name : rtde.missing()) text += "; this controller has no " + name;
  if (!status.is_paused()) return text;
  return {"the speed slider stands at 0 or a program is paused: nothing moves until a person changes that",
          true};
}

Check ask_gripper(const CellConfig& cell) {
  ThreeFingerGripper gripper(cell.gripper);
  const ThreeFingerStatus status = gripper.status();
  if (gripper_fault_kind(status.fault) == GripperFaultKind::kMajor)
    refuse(gripper.name(), gripper_fault_text(status.fault), "empty the hand and activate the gripper");
  std::string text = status.active ? "active"
                                   : "not activated; `run` activates it: it opens and closes fully, so empty "
                                     "the hand first";
  if (status.fault != 0) text += "; " + gripper_fault_text(status.fault);
  return {text, !status.active};
}

/// As many readings as it takes to tell a sensor that repeats one from one at rest.
std::string read_force(const CellConfig& cell) {
  RobotiqFtSensor sensor(cell.force_torque);
  Wrench wrench = sensor.read();
  const long wanted = cell.force_torque.stuck_samples + 10;
  for (const Deadline limit = Deadline::in(3.0); sensor.health().readings < wanted && !limit.over();) {
    throw_if_interrupted();
    wrench = sensor.read();
  }
  return concat("force ", wrench.force.x(), " ", wrench.force.y(), " ", wrench.force.z(), " N, ",
                sensor.firmware().empty() ? "streaming" : sensor.firmware(), ", ", sensor.health().rate,
                " readings/s");
}

/// Two frames or more, so that a camera whose stream or image stands still is found; of a recording the first
/// only.
std::string check_camera(const CellConfig& cell, int frames, DeviceReports& reports) {
  const auto describe = [](const DepthFrame& frame) {
    return concat("frame ", frame.number, ", ", frame.image.camera.width, " x ", frame.image.camera.height);
  };
  const auto camera = make_camera(cell);
  const DepthFrame first = camera->capture();
  if (cell.camera == "recorded") return describe(first);
  DepthFrame last = first;
  for (int k = 1; k < frames; ++k) last = camera->capture();
  reports.image = last.image;
  std::string text =
      concat(describe(last), ", ", last.device_time - first.device_time, " s after the one before");
  if (frames > 2)
    text = concat(describe(last), ", ", frames, " within ", last.device_time - first.device_time, " s");
  if (cell.camera == "v4l2" && !cell.v4l2.record.empty()) text += ", kept in " + cell.v4l2.record;
  return text;
}

double degrees(double angle) {
  return angle * 180.0 / std::numbers::pi;
}

double rounded(double value, double unit) {
  return std::round(value / unit) * unit;
}

/// The hand-eye calibration as the cell file has it.
struct GivenMount {
  std::string name;  ///< "layout.T_T_C"
  MountReading meant = MountReading::kTip;
  Pose numbers = Pose::Identity();
  CellLayout layout;

  explicit GivenMount(const CellConfig& cell) : layout(to_layout(cell)) {
    name = cell.T_F_C ? "layout.hand_eye (" + cell.hand_eye + ")" : "layout.T_T_C";
    meant = cell.T_F_C ? MountReading::kFlange : MountReading::kTip;
    numbers = cell.T_F_C ? *cell.T_F_C : layout.T_T_C;
  }
};

const std::string kHandEye = "hand-eye calibration";
const std::string kCalibrate = "calibrate: `stonestack calibrate PAIRS --write CELL`";

/// "camera 0.17 m behind the finger tips, 0.11 m aside"
std::string place_of(const Pose& T_T_C) {
  const Eigen::Vector3d p = T_T_C.translation();
  return concat("camera ", rounded(std::abs(p.z()), 0.001), " m ", p.z() > 0 ? "in front of" : "behind",
                " the finger tips, ", rounded(std::hypot(p.x(), p.y()), 0.001), " m aside");
}

std::string in_words(const TableOffset& table) {
  return concat(rounded(std::abs(1000 * table.height), 1), " mm ", table.height < 0 ? "below" : "above",
                " z = 0 and tilted by ", rounded(degrees(table.tilt), 0.1), " deg");
}

/// The line for the cell file.
std::string write_instead(const Pose& T_T_C) {
  return concat("if that is right, write `T_T_C: ", mount_text(T_T_C), "` in its place");
}

/// By the numbers alone: nothing here is known to be right, but much is known to be wrong.
Check judge_numbers(const GivenMount& given, const std::string& why_no_view) {
  const Pose& T_T_C = given.layout.T_T_C;
  if (is_possible_mount(T_T_C))
    return {concat(place_of(T_T_C), "; not compared with the table: ", why_no_view), true};
  std::string candidates;
  for (const MountReading reading : kMountReadings)
    if (reading != given.meant && is_possible_mount(mount_of(reading, given.numbers, given.layout.T_F_T)))
      candidates += (candidates.empty() ? "they may be " : ", or ") + to_text(reading);
  refuse(kHandEye,
         concat(given.name, " as ", to_text(given.meant), ": ", place_of(T_T_C),
                T_T_C.linear()(2, 2) > 0 ? "" : ", facing the arm"),
         candidates.empty() ? "nor is it the inverse or another frame; " + kCalibrate : candidates);
  return {""};
}

/// The table that the camera sees, at the place where the mount puts it.
Check judge_view(const GivenMount& given, const Pose& T_W_T, const Plane& table_C) {
  const MountCheck check = check_mount(given.numbers, given.meant, given.layout.T_F_T, T_W_T, table_C);
  const std::string seen =
      concat(place_of(check.meant.T_T_C), "; the table is seen ", in_words(check.meant.table));
  const std::string as_given = concat(given.name, " as ", to_text(given.meant), ": ", seen);
  switch (check.verdict) {
    case MountCheck::Verdict::kOther:
      refuse(kHandEye,
             concat(as_given, "; the numbers look like ", to_text(check.others.front().reading),
                    ": with that it is ", in_words(check.others.front().table)),
             write_instead(check.others.front().T_T_C));
      break;
    case MountCheck::Verdict::kNone:
      refuse(kHandEye, concat(as_given, ", and no other reading of the numbers explains it"),
             "see that the table is in view and layout.T_W_R is right, or " + kCalibrate);
      break;
    case MountCheck::Verdict::kAmbiguous:
      return {
          concat(seen, ", but would be so, too, if the numbers were ", to_text(check.others.front().reading),
                 ": tilt the hand by 20 deg, the table in view, and ask again"),
          true};
    case MountCheck::Verdict::kRough:
      return {concat(seen, "; ", kCalibrate), true};
    case MountCheck::Verdict::kFits:
      break;
  }
  if (!is_possible_mount(check.meant.T_T_C))
    return {concat(seen, "; if the camera is not mounted so, ", kCalibrate), true};
  return concat(seen, " (one view does not show the camera's place along the table)");
}

/// Reason why the view cannot be compared; empty if it can.
std::string obstacle_to_view(const CellConfig& cell, const DeviceReports& reports) {
  if (!reports.q) return "the arm has not said where it is";
  if (cell.camera == "recorded") return "a recording is not from where the arm is now";
  if (!reports.image) return "there is no depth image";
  return "";
}

Check check_hand_eye(const CellConfig& cell, const DeviceReports& reports) {
  const GivenMount given(cell);
  if (const std::string why = obstacle_to_view(cell, reports); !why.empty()) return judge_numbers(given, why);
  const auto table_C = find_table(*reports.image);
  if (!table_C) return judge_numbers(given, "the camera sees none; move the hand over it and ask again");
  const Pose T_W_T = given.layout.T_W_R * forward(read_cell_robot(cell), *reports.q) * given.layout.T_F_T;
  return judge_view(given, T_W_T, *table_C);
}

/// RTDE first: its version tells what else there may be. PolyScope X has no Dashboard, and must not be asked
/// to enable one.
void examine_arm(const CellConfig& cell, DeviceReports& reports, Examination& examination) {
  if (cell.arm.address.empty()) {
    examination.step("cell file", "arm", [&] {
      require_arm_address(cell);
      return Check("");
    });
    return;
  }
  examination.step("arm", "RTDE", [&] { return listen_rtde(cell, reports); });
  if (reports.version.major >= kPolyScopeX) return;
  examination.step("arm", "Dashboard", [&] { return ask_dashboard(cell); });
  examination.step("arm", "script port", [&] { return hear_primary(cell); });
}

void examine(const CellConfig& cell, int frames, Examination& examination) {
  DeviceReports reports;
  examine_arm(cell, reports, examination);
  examination.step("gripper", "status", [&] { return ask_gripper(cell); });
  examination.step("force sensor", "reading", [&] { return read_force(cell); });
  examination.step("camera", "frames", [&] { return check_camera(cell, frames, reports); });
  examination.step("cell file", "hand-eye", [&] { return check_hand_eye(cell, reports); });
}

/// Sets what --set says; the file of a hand-eye calibration is read again.
void apply_settings(Settings& settings, CellFile& file) {
  const PoseNumbers given = file.cell.T_T_C;
  settings.apply(join({fields(file.cell), cell_fields(file)}));
  require(file.cell.hand_eye.empty() || file.cell.T_T_C == given,
          "layout.T_T_C and layout.hand_eye are the same thing: set one of them, with --set layout.hand_eye= "
          "where the file names one");
  read_hand_eye(file.cell);
}

/// Does `stonestack simulate` serve the cell's standard ports already, in another process?
bool is_served(const CellFile& file) {
  if (!file.servers.arm.standard_ports) return false;
  const auto answers = [&](int port) {
    try {
      (void)TcpStream::connect({file.servers.arm.address, port}, Deadline::in(kListen).or_interrupt());
      return true;
    } catch (const DeviceError&) {
      return false;
    }
  };
  const auto& arm = file.cell.arm;
  return answers(arm.dashboard_port) || answers(arm.primary_port) || answers(arm.rtde_port);
}

void doctor(DoctorCommand& command) {
  command.common.begin();
  CellFile file = read_cell(command.cell.empty() ? data_path("cells/loopback-ur10.yaml") : command.cell);
  apply_settings(command.common.settings, file);
  CellConfig cell = file.cell;
  std::unique_ptr<SimulatedCell> world;
  std::unique_ptr<SimulatedServers> servers;
  const bool serve = file.simulate && !is_served(file);
  const Catalogue catalogue = serve ? command.common.read() : Catalogue{};
  if (file.simulate && !serve)
    log_info("the devices of " + file.path + " are simulated by another process, which is examined");
  if (serve) {
    const RobotModel robot = read_robot(cell.robot);
    world = std::make_unique<SimulatedCell>(catalogue.stones, std::vector<int>{0}, robot,
                                            true_layout(to_layout(cell), file.servers));
    servers = std::make_unique<SimulatedServers>(*world, robot, file.servers);
    connect_to(*servers, cell);
    log_info("the devices of " + file.path + " are simulated here");
  }
  Examination examination;
  examine(cell, command.frames, examination);
  int bad = 0;
  nlohmann::json list = nlohmann::json::array();
  for (const auto& finding : examination.findings()) {
    bad += finding.good ? 0 : 1;
    list.push_back({{"device", finding.device},
                    {"step", finding.step},
                    {"good", finding.good},
                    {"to_do", finding.to_do},
                    {"text", finding.text}});
  }
  if (command.common.json)
    std::cout << nlohmann::json{{"schema", "stonestack.doctor/1"}, {"findings", list}}.dump(2) << '\n';
  if (bad > 0)
    throw Error(
        concat(file.path, ": ", bad, " of ", examination.findings().size(), " checks failed, see above"),
        ExitCode::kExecutionFailed);
}

}  // namespace

void add_doctor(CLI::App& app) {
  auto command = std::make_shared<DoctorCommand>();
  CLI::App* sub = app.add_subcommand("doctor", "Check every device of a cell, step by step; moves nothing");
  sub->add_option("--cell", command->cell, "Cell file (default: the loopback cell, simulated here)")
      ->type_name("FILE");
  sub->add_option("--frames", command->frames, "So many depth frames are looked at")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command->common.register_on(*sub);
  sub->footer(
      "Says for each device what is wrong and what to do. Exit code 0 when all is well, 6 otherwise.\n"
      "--set takes what the cell file may hold, and beats it: `stonestack config cell --expert` lists it.\n"
      "Of a simulated cell on the standard ports it examines what `stonestack simulate` serves, if it runs.\n"
      "Examples:\n"
      "  stonestack doctor --cell my_lab.yaml\n"
      "  stonestack doctor --cell my_lab.yaml --frames 300 --set camera.v4l2.record=raw_frames\n"
      "  stonestack doctor --cell simulated-ur10\n"
      "  stonestack doctor --set simulators.gripper.wire_faults.exceptions=-1\n"
      "  stonestack doctor --json");
  sub->callback([command] { doctor(*command); });
}

}  // namespace stonestack::apps
