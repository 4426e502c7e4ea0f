#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cell_input.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "hardware/ur/ur_status.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/data.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/socket.hpp"
#include "stonestack/hardware/ur/dashboard_client.hpp"
#include "stonestack/hardware/ur/primary_client.hpp"

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

/// What a step found: `to_do` is nothing wrong, but something to know or to do before a run.
struct Look {
  Look(std::string all_well) : text(std::move(all_well)) {}  // NOLINT: most looks find only that
  Look(std::string found, bool something_to_do) : text(std::move(found)), to_do(something_to_do) {}
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
  /// `look` returns what it found, or throws with what is wrong. False when it threw.
  bool step(const std::string& device, const std::string& step, const std::function<Look()>& look) {
    throw_if_interrupted();
    Finding finding{device, step, true, false, ""};
    try {
      const Look found = look();
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

/// For a while, so that a stream that breaks again and again is found; with all that a run reads and writes.
Look listen_rtde(const CellConfig& cell, UrVersion& version) {
  const auto recipe = [&, served = served_recipe(cell.arm.address)](const UrVersion& reported) {
    version = reported;
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
  std::string text = concat("protocol ", rtde.protocol(), ", controller time ", sample.device_time(),
                            " s, joints ", status.q.transpose(), " rad");
  for (const std::string& name : rtde.missing()) text += "; this controller has no " + name;
  if (!status.is_paused()) return text;
  return {"the speed slider stands at 0 or a program is paused: nothing moves until a person changes that",
          true};
}

Look ask_gripper(const CellConfig& cell) {
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
std::string look(const CellConfig& cell, int frames) {
  const auto describe = [](const DepthFrame& frame) {
    return concat("frame ", frame.number, ", ", frame.image.camera.width, " x ", frame.image.camera.height);
  };
  const auto camera = make_camera(cell);
  const DepthFrame first = camera->capture();
  if (cell.camera == "recorded") return describe(first);
  DepthFrame last = first;
  for (int k = 1; k < frames; ++k) last = camera->capture();
  std::string text =
      concat(describe(last), ", ", last.device_time - first.device_time, " s after the one before");
  if (frames > 2)
    text = concat(describe(last), ", ", frames, " within ", last.device_time - first.device_time, " s");
  if (cell.camera == "v4l2" && !cell.v4l2.record.empty()) text += ", kept in " + cell.v4l2.record;
  return text;
}

/// The camera sits behind the finger tips and looks where the hand points. The inverse transform puts it
/// before them; how steeply it looks is the same in either.
Look check_hand_eye(const CellConfig& cell) {
  constexpr double kBefore = 0.02, kSteep = 0.5;  // m; cosine, to where the hand points
  const std::string name = "hand-eye calibration", remedy = "see `stonestack calibrate`";
  const Pose T_T_C = to_layout(cell).T_T_C;
  const Eigen::Vector3d p = T_T_C.translation();
  const double view = T_T_C.linear()(2, 2);
  if (p.z() > kBefore)
    refuse(name, concat("layout.T_T_C puts the camera ", p.z(), " m in front of the finger tips"),
           T_T_C.inverse().translation().z() <= kBefore
               ? "it looks like T_C_T, the inverse: " + remedy
               : "neither it nor its inverse can be right: " + remedy);
  if (view <= 0)
    refuse(name, concat("layout.T_T_C has the camera look back at the arm (z by ", view, ")"), remedy);
  const std::string place =
      concat("camera ", -p.z(), " m behind the finger tips, ", std::hypot(p.x(), p.y()), " m aside");
  if (view >= kSteep) return place;
  return {concat(place, ", looking ", std::acos(view) * 180 / std::numbers::pi,
                 " deg away from where the hand points; if it is not mounted so, ", remedy),
          true};
}

/// RTDE first: its version tells what else there may be. PolyScope X has no Dashboard, and must not be asked
/// to enable one.
void examine_arm(const CellConfig& cell, Examination& examination) {
  if (cell.arm.address.empty()) {
    examination.step("cell file", "arm", [&] {
      require_arm_address(cell);
      return Look("");
    });
    return;
  }
  UrVersion version;
  examination.step("arm", "RTDE", [&] { return listen_rtde(cell, version); });
  if (version.major >= kPolyScopeX) return;
  examination.step("arm", "Dashboard", [&] { return ask_dashboard(cell); });
  examination.step("arm", "script port", [&] { return hear_primary(cell); });
}

void examine(const CellConfig& cell, int frames, Examination& examination) {
  examination.step("cell file", "hand-eye", [&] { return check_hand_eye(cell); });
  examine_arm(cell, examination);
  examination.step("gripper", "status", [&] { return ask_gripper(cell); });
  examination.step("force sensor", "reading", [&] { return read_force(cell); });
  examination.step("camera", "frames", [&] { return look(cell, frames); });
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
  command.common.settings.apply(join({fields(file.cell), cell_fields(file)}));
  CellConfig cell = file.cell;
  std::unique_ptr<SimulatedCell> world;
  std::unique_ptr<SimulatedServers> servers;
  const bool serve = file.simulate && !is_served(file);
  const Catalogue catalogue = serve ? command.common.read() : Catalogue{};
  if (file.simulate && !serve)
    log_info("the devices of " + file.path + " are simulated by another process, which is examined");
  if (serve) {
    const RobotModel robot = read_robot(cell.robot);
    world = std::make_unique<SimulatedCell>(catalogue.stones, std::vector<int>{0}, robot, to_layout(cell));
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
