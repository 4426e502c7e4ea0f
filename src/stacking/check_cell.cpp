#include "stonestack/stacking/check_cell.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "hardware/cell_config.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "hardware/ur/primary_client.hpp"
#include "hardware/ur/ur_status.hpp"
#include "stacking/check_hand_eye.hpp"
#include "stacking/examination.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr const char* kNotActivated =
    "not activated; `run` activates it: it opens and closes fully, so empty the gripper first";

constexpr std::uint32_t kPolyScopeX = 10;
constexpr double kListen = 1.0;   // s to RTDE
constexpr double kFeel = 3.0;     // s to the force sensor, at most
constexpr int kBeyondStuck = 10;  // readings more than those that show a sensor that repeats one
constexpr double kHello = 2.0;    // s until a controller has said who it is; it sends a state every 0.1 s

std::string ask_dashboard(const CellConfig& cell) {
  DashboardClient dashboard({cell.arm.address, cell.arm.dashboard_port});
  const UrVersion version = dashboard.version();
  dashboard.require_serial(cell.arm.serial);
  const std::string mode = dashboard.robot_mode(), safety = dashboard.safety();
  const auto remote = dashboard.is_in_remote_control();
  const std::string name = "UR controller at " + cell.arm.address;
  if (version.major >= kPolyScopeX)
    throw DeviceError(name, "PolyScope X is not supported", "use a CB3 or an e-Series controller");
  if (remote && !*remote)
    throw DeviceError(name, "is in local mode and ignores programs from outside",
                      "switch to Remote Control on the pendant");
  if (safety != "NORMAL" && safety != "REDUCED")
    throw DeviceError(name, "safety is " + safety, "look at the cell, then clear the stop on the pendant");
  if (mode != "RUNNING")
    throw DeviceError(name, "robot mode is " + mode, "switch on and release the brakes on the pendant");
  return concat("PolyScope ", to_string(version), ", robot ", mode, ", safety ", safety,
                remote ? ", remote control" : "");
}

std::string hear_primary(const CellConfig& cell) {
  PrimaryOptions options;
  options.ports = {cell.arm.primary_port, cell.arm.secondary_port, cell.arm.realtime_port};
  std::erase(options.ports, 0);  // left out
  const PrimaryClient primary(cell.arm.address, options);
  primary.wait_until_heard(Deadline::in(kHello));
  const auto checksum = primary.wait_for_safety_checksum(Deadline::in(kHello));
  if (const auto other = describe_other_safety(checksum, cell.arm.safety_checksum); !other.empty())
    throw DeviceError("UR controller at " + cell.arm.address, other, kCompareSafety);
  const std::string port = concat("scripts go to port ", primary.port(), "; safety configuration ");
  if (!checksum) return port + "without a checksum: that it stays as it is cannot be checked";
  return concat(port, checksum_text(*checksum),
                cell.arm.safety_checksum.empty()
                    ? ": once it is right, write this as arm.safety_checksum, and nothing moves with another"
                    : ", as the cell has it");
}

/// Listens for a while, so that a stream that breaks again and again is found; with all that a run reads and
/// writes. The controller's version is known as soon as it says it, also where the rest fails.
Found listen_rtde(const CellConfig& cell, UrVersion& version, CellView& view) {
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
    throw DeviceError(concat("UR RTDE at ", cell.arm.address, ":", cell.arm.rtde_port),
                      concat("the stream broke ", lost, " times within ", kListen, " s"),
                      "look at cable and switch, and at the controller's log");
  const UrStatus status = read_status(sample, first_register(rtde.version()));
  view.q = status.q;
  std::string text = concat("protocol ", rtde.protocol(), ", controller time ", sample.device_time(),
                            " s, joints ", status.q.transpose(), " rad");
  for (const std::string& name : rtde.missing()) text += "; this controller has no " + name;
  if (!status.is_paused()) return {text};
  return {"the speed slider stands at 0 or a program is paused: nothing moves until a person changes that",
          true};
}

Found ask_two_fingers(const CellConfig& cell) {
  TwoFingerGripper gripper(two_finger_options(cell));
  const TwoFingerStatus status = gripper.status();
  if (is_major_two_finger_fault(status.fault))
    throw DeviceError(gripper.name(), two_finger_fault_text(status.fault),
                      "empty the gripper and activate the gripper");
  std::string text = status.active ? "active" : kNotActivated;
  if (status.fault != 0) text += "; " + two_finger_fault_text(status.fault);
  return {text, !status.active};
}

Found ask_gripper(const CellConfig& cell) {
  if (cell.gripper_driver == "robotiq_2f") return ask_two_fingers(cell);
  ThreeFingerGripper gripper(cell.gripper);
  const ThreeFingerStatus status = gripper.status();
  if (gripper_fault_kind(status.fault) == GripperFaultKind::kMajor)
    throw DeviceError(gripper.name(), gripper_fault_text(status.fault),
                      "empty the gripper and activate the gripper");
  std::string text = status.active ? "active" : kNotActivated;
  if (status.fault != 0) text += "; " + gripper_fault_text(status.fault);
  return {text, !status.active};
}

std::string force_text(const Wrench& wrench) {
  return concat("force ", wrench.force.x(), " ", wrench.force.y(), " ", wrench.force.z(), " N");
}

std::string read_own_sensor(const CellConfig& cell) {
  UrForceTorque sensor(cell.arm, cell.force_torque);
  const Wrench first = sensor.read();
  Wrench wrench = first;
  int readings = 1;
  for (const Deadline limit = Deadline::in(kFeel);
       readings < cell.force_torque.stuck_samples + kBeyondStuck && !limit.over(); ++readings) {
    throw_if_interrupted();
    wrench = sensor.read();
  }
  return concat("the arm's own, ft_raw_wrench of PolyScope ", to_string(sensor.version()), ", ",
                force_text(wrench), " beside the first reading, ",
                (readings - 1) / std::max(1e-3, wrench.device_time - first.device_time), " readings/s");
}

/// Takes as many readings as tell a sensor that repeats one from one at rest.
std::string read_force(const CellConfig& cell) {
  if (cell.has_own_sensor()) return read_own_sensor(cell);
  RobotiqFtSensor sensor(cell.force_torque);
  Wrench wrench = sensor.read();
  const long wanted = cell.force_torque.stuck_samples + kBeyondStuck;
  for (const Deadline limit = Deadline::in(kFeel); sensor.health().readings < wanted && !limit.over();) {
    throw_if_interrupted();
    wrench = sensor.read();
  }
  return concat("Robotiq, ", force_text(wrench), ", ",
                sensor.firmware().empty() ? "streaming" : sensor.firmware(), ", ", sensor.health().rate,
                " readings/s");
}

/// Takes two frames or more, so that a camera whose stream or image stands still is found; of a recording the
/// first only.
std::string take_frames(const CellConfig& cell, int frames, CellView& view) {
  const auto describe = [](const DepthFrame& frame) {
    return concat("frame ", frame.number, ", ", frame.image.camera.width, " x ", frame.image.camera.height);
  };
  const auto camera = make_camera(cell);
  const DepthFrame first = camera->capture();
  if (cell.camera == "recorded") return describe(first);
  DepthFrame last = first;
  for (int k = 1; k < frames; ++k) last = camera->capture();
  view.image = last.image;
  std::string text =
      concat(describe(last), ", ", last.device_time - first.device_time, " s after the one before");
  if (frames > 2)
    text = concat(describe(last), ", ", frames, " within ", last.device_time - first.device_time, " s");
  if (cell.camera == "v4l2" && !cell.v4l2.record.empty()) text += ", kept in " + cell.v4l2.record;
  return text;
}

/// Asks RTDE first: its version tells what else there may be. PolyScope X has no Dashboard, and must not be
/// asked to enable one.
void examine_arm(const CellConfig& cell, CellView& view, Examination& examination) {
  if (cell.arm.address.empty()) {
    examination.check("cell file", "arm", [&] {
      require_arm_address(cell);
      return Found{};
    });
    return;
  }
  UrVersion version;
  examination.check("arm", "RTDE", [&] { return listen_rtde(cell, version, view); });
  if (version.major >= kPolyScopeX) return;
  examination.check("arm", "Dashboard", [&] { return ask_dashboard(cell); });
  examination.check("arm", "script port", [&] { return hear_primary(cell); });
}

}  // namespace

std::string to_text(const CellCheck& check) {
  const char* mark = check.verdict == CellCheck::Verdict::kFailed ? "FAIL  "
                     : check.verdict == CellCheck::Verdict::kNote ? "note  "
                                                                  : "ok    ";
  return concat(mark, check.device, ", ", check.step, ": ", check.text);
}

int CellReport::failed() const {
  return static_cast<int>(std::count_if(checks.begin(), checks.end(), [](const CellCheck& check) {
    return check.verdict == CellCheck::Verdict::kFailed;
  }));
}

std::string cell_report_json(const CellReport& report) {
  nlohmann::json findings = nlohmann::json::array();
  for (const CellCheck& check : report.checks)
    findings.push_back({{"device", check.device},
                        {"step", check.step},
                        {"good", check.verdict != CellCheck::Verdict::kFailed},
                        {"to_do", check.verdict == CellCheck::Verdict::kNote},
                        {"text", check.text}});
  return nlohmann::json{{"schema", "stonestack.doctor/1"}, {"findings", findings}}.dump(2) + "\n";
}

CellReport check_cell(const CellConfig& cell, const CellCheckOptions& options) {
  Examination examination(options.on_check);
  CellView view;
  examine_arm(cell, view, examination);
  examination.check("gripper", "status", [&] { return ask_gripper(cell); });
  examination.check("force sensor", "reading", [&] { return read_force(cell); });
  examination.check("camera", "frames", [&] { return take_frames(cell, options.frames, view); });
  examination.check("cell file", "hand-eye", [&] { return check_hand_eye(cell, view); });
  return examination.report();
}

}  // namespace stonestack::stacking
