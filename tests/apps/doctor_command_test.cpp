// Reports of `stonestack doctor` on cells with and without faults.
#include <signal.h>

#include <chrono>
#include <thread>

#include "commands.hpp"
#include "core/socket.hpp"
#include "stonestack/core/clock.hpp"

namespace stonestack {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::Not;

using DoctorCommand = Commands;

/// Of tests that run beside the one that has the standard ports.
constexpr const char* kFreePorts =
    "simulators:\n  arm: {standard_ports: false}\n  gripper: {port: 0}\n"
    "  force_torque: {port: 0, command_port: 0}\n  camera: {port: 0}\n";

TEST_F(DoctorCommand, NamesTheForceSensor) {
  const Outcome own = run("doctor --cell loopback-ur10e");
  EXPECT_EQ(own.code, 0) << own.out << own.err;
  EXPECT_THAT(own.out, ContainsRegex("ok    force sensor, reading: the arm's own, ft_raw_wrench of PolyScope "
                                     "5.12.*readings/s"));
  const Outcome old = run("doctor --cell loopback-ur10e --set simulators.arm.version=5.8.2.10297");
  EXPECT_EQ(old.code, 6);
  EXPECT_THAT(old.out, ContainsRegex("FAIL  force sensor, reading: .*127.0.0.1.*5.8.2.*PolyScope 5.9"));
  EXPECT_THAT(run("doctor --cell loopback-ur10").out,
              ContainsRegex("ok    force sensor, reading: Robotiq, force"));
}

TEST_F(DoctorCommand, ComparesTheSafetyConfigurationWithTheCells) {
  const std::string cell = "doctor --cell loopback-ur10 --set simulators.arm.safety_checksum=57F4285B";
  EXPECT_THAT(run(cell).out, ContainsRegex("ok    arm, script port: .*safety configuration 57F4285B: .*"
                                           "arm.safety_checksum"));
  EXPECT_THAT(run(cell + " --set arm.safety_checksum=57F4285B").out,
              ContainsRegex("ok    arm, script port: .*57F4285B, as the cell has it"));
  const Outcome other = run(cell + " --set arm.safety_checksum=57F4285C");
  EXPECT_EQ(other.code, 6);
  EXPECT_THAT(other.out, ContainsRegex("FAIL  arm, script port: .*57F4285B.*57F4285C.*on the pendant"));
}

TEST_F(DoctorCommand, NamesWhatIsWrong) {
  const Outcome well = run("doctor --json");
  EXPECT_EQ(well.code, 0) << well.err;
  EXPECT_EQ(well.data()["findings"].size(), 7u);
  EXPECT_THAT(well.err, HasSubstr("note  gripper, status: not activated"));
  write("ill.yaml",
        "simulate: true\nlayout: {T_T_C: {x: 0, y: -0.0788, z: 0.1865, qx: -0.0871557, qy: 0, qz: 0, qw: "
        "0.9961947}}\n"
        "simulators: {arm: {faults: {protective_stop_at: 0.0}}}\n");
  const Outcome ill = run("doctor --cell ill.yaml");
  EXPECT_EQ(ill.code, 6);
  EXPECT_THAT(ill.out, HasSubstr("inverse"));
  EXPECT_THAT(ill.out, HasSubstr("PROTECTIVE_STOP"));
  // What else a user meets, two or three to a cell: each line names device, address and next step.
  write("e_series.yaml",
        "simulate: true\nsimulators:\n"
        "  arm: {version: 5.12.2.1101534, faults: {local_mode: true, no_rtde: true}}\n"
        "  camera: {faults: {repeated: -1}}\n"
        "  gripper: {faults: {fault: 14}}\n");
  const Outcome local = run("doctor --cell e_series.yaml");
  EXPECT_EQ(local.code, 6);
  EXPECT_THAT(local.out, ContainsRegex("FAIL  arm, Dashboard: .*127.0.0.1.*local mode.*Remote Control"));
  EXPECT_THAT(local.out, ContainsRegex("FAIL  arm, RTDE: .*127.0.0.1:30004.*security settings"));
  EXPECT_THAT(local.out, ContainsRegex("FAIL  camera, frames: .*127.0.0.1:[0-9]+.*stale"));
  EXPECT_THAT(local.out, ContainsRegex("FAIL  gripper, status: .*127.0.0.1:[0-9]+ unit 2.*activate"));
  write("old_cb3.yaml",
        "simulate: true\nsimulators:\n"
        "  arm: {version: 3.8.0.61336, faults: {fieldbus_owns_lower_registers: true, no_dashboard: true}}\n"
        "  force_torque: {faults: {silent: true}}\n"
        "  camera: {faults: {no_frame: -1}}\n");
  const Outcome owned = run("doctor --cell old_cb3.yaml");
  EXPECT_EQ(owned.code, 6);
  EXPECT_THAT(owned.out, ContainsRegex("FAIL  arm, RTDE: .*input_int_register_0.*EtherNet/IP"));
  EXPECT_THAT(owned.out, ContainsRegex("FAIL  arm, Dashboard: .*127.0.0.1:29999.*security settings"));
  EXPECT_THAT(owned.out, ContainsRegex("FAIL  force sensor, reading: .*127.0.0.1"));
  EXPECT_THAT(owned.out, ContainsRegex("FAIL  camera, frames: .*127.0.0.1"));
  write("another.yaml", "simulate: true\narm: {serial: \"2099999999\"}\n");
  EXPECT_THAT(run("doctor --cell another.yaml").out,
              ContainsRegex("FAIL  arm, Dashboard: .*serial number [0-9]+.*arm.serial is 2099999999"));
  // What shows only when one listens for a while.
  write("odd.yaml",
        "simulate: true\narm: {rtde: {stale_after: 1.0, retry_pause: 0.05}}\nforce_torque: {stale: "
        "0.5}\nsimulators:\n"
        "  arm: {faults: {speed_slider: 0, missing_fields: tcp_offset}}\n"
        "  force_torque: {faults: {stuck: true}}\n");
  const Outcome odd = run("doctor --cell odd.yaml");
  EXPECT_THAT(odd.out, ContainsRegex("note  arm, RTDE: the speed slider stands at 0"));
  EXPECT_THAT(odd.out, ContainsRegex("FAIL  force sensor, reading: .*repeats one reading"));
  write("broken.yaml",
        "simulate: true\narm: {rtde: {stale_after: 1.0, retry_pause: 0.05}}\nsimulators:\n"
        "  arm: {faults: {out_of_step: true}}\n  gripper: {wire_faults: {exceptions: -1}}\n");
  const Outcome broken = run("doctor --cell broken.yaml");
  EXPECT_THAT(broken.out, ContainsRegex("FAIL  arm, RTDE: .*the stream broke [0-9]+ times"));
  EXPECT_THAT(broken.out, ContainsRegex("FAIL  gripper, status: .*busy.*see what else uses the gripper"));
}

/// The finding about the hand-eye calibration of one simulated cell; `camera` are settings of its camera.
class DoctorHandEye : public Commands {
 protected:
  [[nodiscard]] std::string finding(const std::string& layout, const std::string& camera = "") const {
    write("eye.yaml", "simulate: true  # in a test\nlayout:\n  " + layout +
                          "\nsimulators:\n  arm: {standard_ports: false}\n  gripper: {port: 0}\n"
                          "  force_torque: {port: 0, command_port: 0}\n  camera: {port: 0" +
                          camera + "}\n");
    return finding_of("eye.yaml");
  }
  [[nodiscard]] std::string finding_of(const std::string& cell) const {
    const std::string out = run("doctor --cell " + cell).out;
    const auto end = out.find("cell file, hand-eye");
    if (end == std::string::npos) return out;
    const auto begin = out.rfind('\n', end) + 1;
    return out.substr(begin, out.find('\n', end) - begin);
  }
  static std::string written(const Pose& pose) { return "T_T_C: " + to_text(pose); }

  static constexpr const char* kStandard =
      "x: 0.0, y: 0.11, z: -0.17, qx: 0.0871557, qy: 0.0, qz: 0.0, qw: 0.9961947";  // as lab-ur10.yaml has it
};

TEST_F(DoctorHandEye, ACalibrationThatWasWrittenIntoTheCellIsRight) {
  ASSERT_EQ(run("calibrate --simulate 15 --seed 1 --out eye_in_flange.yaml").code, 0);
  EXPECT_THAT(finding("hand_eye: eye_in_flange.yaml"), HasSubstr("ok    cell file, hand-eye"));
  const std::string cell =
      concat("# my cell\nsimulate: true\nlayout:\n  site: {x: 0.7}  # tower\n", kFreePorts);
  write("cell.yaml", cell);
  ASSERT_EQ(run("calibrate --simulate 15 --seed 1 --write cell.yaml").code, 0);
  const std::string now = read_file(folder_ + "/cell.yaml", 1 << 16);
  const auto line = now.find("  T_T_C: {x: ");
  ASSERT_NE(line, std::string::npos) << now;
  std::string rest = now;
  EXPECT_EQ(rest.erase(line, now.find('\n', line) + 1 - line), cell) << "nothing else has changed";
  EXPECT_THAT(finding_of("cell.yaml"), HasSubstr("ok    cell file, hand-eye"));
  EXPECT_THAT(now, HasSubstr(", z: -0.1")) << "in the finger tips, not in the flange";
}

TEST_F(DoctorHandEye, NamesTheFrameThatTheNumbersAreIn) {
  ASSERT_EQ(run("calibrate --simulate 15 --seed 1 --out eye.yaml --json > eye.json").code, 0);
  const Pose T_F_C = pose_of(json::parse(read_file(folder_ + "/eye.json", 1 << 20)).at("T_A_C"));
  const auto names = [](const char* frame) {
    return ContainsRegex(
        concat("^FAIL  cell file, hand-eye: .*look like ", frame, ",.*write `T_T_C: .*z: -0.1[67]"));
  };
  EXPECT_THAT(finding(written(T_F_C)), names("T_F_C"));
  EXPECT_THAT(finding(written(T_F_C.inverse())), names("T_C_F"));
  EXPECT_THAT(
      finding("T_T_C: {x: 0.0, y: -0.0788, z: 0.1865, qx: -0.0871557, qy: 0.0, qz: 0.0, qw: 0.9961947}"),
      names("T_C_T"));
  // A file that holds what the cell wants in T_T_C, and one that is 166 mm off without being anything else.
  write("tip.yaml", concat("parameters: {eye_on_hand: true}\ntransformation: {", kStandard, "}\n"));
  EXPECT_THAT(finding("hand_eye: tip.yaml"), names("T_T_C"));
  EXPECT_THAT(finding("T_T_C: {x: 0.0, y: 0.11, z: -0.336, qx: 0.0871557, qy: 0.0, qz: 0.0, qw: 0.9961947}"),
              ContainsRegex("^FAIL  cell file, hand-eye: .*no other reading.*calibrate"));
}

TEST_F(DoctorHandEye, ReportsWhatCannotBeChecked) {
  // Straight down from half way between flange and finger tips: T_C_F puts the camera as high.
  const std::string halfway = "x: 0.0, y: 0.11, z: -0.132, qx: 0.0, qy: 0.0, qz: 0.0, qw: 1.0";
  EXPECT_THAT(finding("T_T_C: {" + halfway + "}", ", T_T_C: {" + halfway + "}"),
              ContainsRegex("^note  cell file, hand-eye: .*T_C_F.*tilt the gripper"));
  // Without a picture of the table only what cannot be is refused.
  const std::string blind = ", faults: {empty: -1}";
  EXPECT_THAT(finding(concat("T_T_C: {", kStandard, "}"), blind),
              ContainsRegex("^note  cell file, hand-eye: camera 0.17 m behind.*not compared with the table"));
  EXPECT_THAT(
      finding("T_T_C: {x: 0.0, y: 0.11, z: 0.094, qx: 0.0871557, qy: 0.0, qz: 0.0, qw: 0.9961947}", blind),
      ContainsRegex("^FAIL  cell file, hand-eye: .*in front of.*T_C_T.*or T_F_C"));
  EXPECT_THAT(finding("T_T_C: {x: 0.0, y: 0.11, z: -0.17, qx: 1, qy: 0.0, qz: 0.0, qw: 0}", blind),
              AllOf(HasSubstr("FAIL  cell file, hand-eye"), HasSubstr("facing the arm")));
}

// Turned is not inverted: a camera that points 40 deg aside is right where the simulated one does, too.
TEST_F(DoctorHandEye, ATiltedCameraIsNoInverse) {
  const std::string tilted = "x: 0.0, y: 0.11, z: -0.17, qx: 0.3420201, qy: 0.0, qz: 0.0, qw: 0.9396926";
  EXPECT_THAT(finding("T_T_C: {" + tilted + "}", ", T_T_C: {" + tilted + "}"),
              AllOf(HasSubstr("ok    cell file, hand-eye"), Not(HasSubstr("inverse"))));
}

TEST_F(DoctorHandEye, SettingsOverrideTheFile) {
  ASSERT_EQ(run("calibrate --simulate 15 --seed 1 --out eye.yaml").code, 0);
  write("cell.yaml",
        concat("simulate: true\nlayout: {T_T_C: {x: 0.0, y: 0.11, z: 0.094, qx: 0, qw: 1}}\n", kFreePorts));
  EXPECT_EQ(run("doctor --cell cell.yaml --set layout.hand_eye=eye.yaml").code, 0);
  expect_refusal("doctor --cell cell.yaml --set layout.hand_eye=eye.yaml --set layout.T_T_C.x=0.1", 2,
                 {"layout.T_T_C and layout.hand_eye"});
}

TEST_F(DoctorCommand, RefusesPolyScopeX) {
  write("x.yaml",
        "simulate: true\nsimulators:\n  arm: {version: 10.7.0.0, standard_ports: false}\n"
        "  gripper: {port: 0}\n  force_torque: {port: 0, command_port: 0}\n  camera: {port: 0}\n");
  const Outcome refused = run("doctor --cell x.yaml");
  EXPECT_EQ(refused.code, 6);
  EXPECT_THAT(refused.out, ContainsRegex("FAIL  arm, RTDE: UR controller at 127.*PolyScope X 10.7.0.0"));
  EXPECT_THAT(refused.out, Not(HasSubstr("Dashboard"))) << "there is none to be enabled";
}

/// A cell all of whose ports take connections and say nothing.
struct SilentCell {
  TcpListener listener{ListenOptions{}};
  [[nodiscard]] std::string text() const {
    const int port = listener.endpoint().port;
    return concat("simulate: false\narm: {address: 127.0.0.1, rtde_port: ", port, ", primary_port: ", port,
                  ", secondary_port: 0, realtime_port: 0, dashboard_port: ", port,
                  ", rtde: {attempts: 1, reply_timeout: 0.2}}\ngripper: {address: 127.0.0.1, port: ", port,
                  "}\nforce_torque: {link: ur_cap, address: 127.0.0.1, port: ", port,
                  "}\ncamera: {driver: stream, stream: {address: 127.0.0.1, port: ", port,
                  ", frame_timeout: 0.2}}\n");
  }
};

TEST_F(DoctorCommand, AnOpenPortIsNoController) {
  const SilentCell silent;
  write("silent.yaml", silent.text());
  const Outcome heard = run("doctor --cell silent.yaml");
  EXPECT_EQ(heard.code, 6);
  EXPECT_THAT(heard.out,
              ContainsRegex("FAIL  arm, script port: .*127.0.0.1:[0-9]+: says neither.*primary_port"));
  EXPECT_THAT(heard.out, Not(HasSubstr("ok    arm")));
}

TEST_F(DoctorCommand, CtrlCEndsItAtOnce) {
  const SilentCell silent;
  std::string text = silent.text();
  const std::string soon = "reply_timeout: 0.2";
  write("silent.yaml", text.replace(text.find(soon), soon.size(), "reply_timeout: 60"));
  const Stopwatch watch;
  const Outcome ended = shell(concat("cd ", folder_, " && timeout --preserve-status -s INT 1 ",
                                     STONESTACK_BINARY, " doctor --cell silent.yaml 2>err"));
  EXPECT_LT(watch.seconds(), 40) << "it does not wait for the controller";
  EXPECT_EQ(ended.code, 130);
  EXPECT_THAT(ended.out, Not(HasSubstr("FAIL"))) << "and checks nothing else";
}

TEST_F(DoctorCommand, ReportsThatACellHasNoAddressOfAnArm) {
  write("empty.yaml", "");
  const Outcome run_it = run("run --cell empty.yaml --execute");
  EXPECT_EQ(run_it.code, 3);
  EXPECT_THAT(run_it.err, AllOf(HasSubstr("empty.yaml"), HasSubstr("arm.address is missing")));
}

TEST_F(DoctorCommand, ExaminesWhatAnotherProcessServes) {
  // The test's own process and address, so that tests may run beside each other.
  const std::string address = concat("127.0.", ::getpid() / 250 % 250 + 1, ".", ::getpid() % 250 + 1);
  write("cell.yaml",
        concat("simulate: true\narm: {address: ", address,
               ", rtde: {stale_after: 1.0}}\ngripper: {preset: tcp2018, address: ", address,
               ", port: 15502}\nforce_torque: {link: ur_cap, address: ", address,
               ", port: 63351}\ncamera: {driver: stream, stream: {address: ", address,
               ", port: 30100}}\nsimulators:\n  arm: {address: ", address,
               ", standard_ports: true, faults: {speed_slider: 0}}\n  gripper: {address: ", address,
               ", port: 15502}\n  force_torque: {address: ", address,
               ", port: 63351, command_port: 63350}\n  camera: {address: ", address, ", port: 30100}\n"));
  const Outcome started = run(concat("--version > version; (", STONESTACK_BINARY,
                                     " simulate --cell cell.yaml --seconds 120 > served 2>&1 & echo $!)"));
  const Stopwatch watch;
  while (read_file(folder_ + "/served", 1 << 16).find("serving until") == std::string::npos &&
         watch.seconds() < 60)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  // A cell file of its own without the fault: what is found is what the other process does.
  std::string text = read_file(folder_ + "/cell.yaml", 1 << 16);
  const std::string fault = ", faults: {speed_slider: 0}";
  write("mine.yaml", text.replace(text.find(fault), fault.size(), ""));
  const Outcome seen = run("doctor --cell mine.yaml");
  ::kill(std::stoi(started.out), SIGTERM);
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_THAT(seen.err, HasSubstr("simulated by another process"));
  EXPECT_THAT(seen.out, HasSubstr("note  arm, RTDE: the speed slider stands at 0"));
}

}  // namespace
}  // namespace stonestack
