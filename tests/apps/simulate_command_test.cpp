// `stonestack simulate` for single devices, and cells whose simulated devices are not on TCP.
#include "commands.hpp"

namespace stonestack {
namespace {

using SimulateCommand = Commands;

const std::string kSimulateCommandFreePorts =
    "simulate: true\narm: {rtde: {stale_after: 1.0}}\nforce_torque: {stale: 0.5}\nsimulators:\n"
    "  arm: {standard_ports: false}\n  camera: {port: 0}\n";

TEST_F(SimulateCommand, ServesEachDeviceAlone) {
  write("cell.yaml",
        kSimulateCommandFreePorts + "  gripper: {port: 0}\n  force_torque: {port: 0, command_port: 0}\n");
  const auto served = [&](const std::string& only) {
    const Outcome outcome = run("simulate --cell cell.yaml --seconds 0.1 --only " + only);
    EXPECT_EQ(outcome.code, 0) << only << "\n" << outcome.err;
    std::string devices;
    for (const auto* device : {"UR controller", "gripper", "force sensor", "depth camera"})
      if (outcome.out.find(device) != std::string::npos) devices += concat(device, ";");
    return devices;
  };
  EXPECT_EQ(served("arm"), "UR controller;");
  EXPECT_EQ(served("gripper"), "gripper;");
  EXPECT_EQ(served("ft"), "force sensor;");
  EXPECT_EQ(served("camera"), "depth camera;");
  EXPECT_EQ(served("ft,camera --only arm"), "UR controller;force sensor;depth camera;");
  expect_refusal("simulate --cell cell.yaml --only wrist", 2, {"--only", "wrist", "arm", "camera"});
}

TEST_F(SimulateCommand, AGripperThatHoldsNoStoneIsServedWithoutAnArm) {
  write("cell.yaml", "hand: \"robotiq-hand-e\"\n" + kSimulateCommandFreePorts + "  gripper: {port: 0}\n");
  const Outcome alone = run("simulate --cell cell.yaml --seconds 0.1 --only gripper");
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_THAT(alone.out, HasSubstr("gripper "));
  EXPECT_THAT(alone.err, HasSubstr("no stone of the catalogue can be carried by this gripper"));
  const Outcome with_arm = run("simulate --cell cell.yaml --seconds 0.1 --only arm,gripper");
  EXPECT_NE(with_arm.code, 0);
  EXPECT_THAT(with_arm.err, HasSubstr("no stone of the catalogue can be carried"));
}

// Every fault can be reached without writing a file.
TEST_F(SimulateCommand, SwitchesCanBeSetOnTheCommandLine) {
  write("cell.yaml",
        kSimulateCommandFreePorts + "  gripper: {port: 0}\n  force_torque: {port: 0, command_port: 0}\n");
  const Outcome closed =
      run("simulate --cell cell.yaml --seconds 0.1 --only arm --set simulators.arm.faults.no_dashboard=true");
  EXPECT_EQ(closed.code, 0) << closed.err;
  EXPECT_THAT(closed.out, HasSubstr("Dashboard 0\n"));
  expect_refusal("simulate --cell cell.yaml --set simulators.arm.faults.no_such=1", 2, {"no_such"});
  const Outcome ill = run("doctor --cell cell.yaml --set simulators.gripper.faults.fault=14");
  EXPECT_EQ(ill.code, 6);
  EXPECT_THAT(ill.out, HasSubstr("FAIL  gripper, status"));
  expect_refusal("doctor --cell cell.yaml --set simulators.gripper.faults.fulat=14", 2, {"fulat"});
  const Outcome stopped =
      run("run --cell cell.yaml --out stopped --per-run 1 --set simulators.arm.faults.protective_stop_at=0");
  EXPECT_EQ(stopped.code, 7) << stopped.err;
}

/// Before the shapes are made, which takes seconds.
TEST_F(SimulateCommand, ReportsAtOnceWhatItIsDoing) {
  const Outcome outcome = run("simulate --cell simulated-ur10 --catalogue nowhere");
  EXPECT_EQ(outcome.code, 3);
  const std::size_t message = outcome.err.find("making the simulated cell of "),
                    refused = outcome.err.find("nowhere");
  ASSERT_NE(message, std::string::npos) << outcome.err;
  EXPECT_LT(message, refused);
  expect_refusal("simulate --cell simulated-ur10 --per-run 9", 2, {"--per-run 9", "has 6 stones"});
}

TEST_F(SimulateCommand, SerialDevicesAreMetOnTheirPseudoTerminals) {
  const std::string serial =
      kSimulateCommandFreePorts +
      "  gripper: {tcp: false, rtu: true}\n  force_torque: {cap: false, serial: true}\n";
  // Whether the cell file asks for the serial lines or not: nothing else is there.
  for (const std::string wish : {"", "gripper: {preset: rtu, device: /none}\n"}) {
    write("serial.yaml", wish + serial);
    const Outcome outcome = run("doctor --cell serial.yaml");
    EXPECT_EQ(outcome.code, 0) << wish << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("note  gripper, status: not activated"));
    EXPECT_THAT(outcome.out, HasSubstr("ok    force sensor, reading"));
  }
  // Where both are served the cell file chooses; a fault of the serial line shows which it was.
  write("both.yaml", "gripper: {preset: rtu}\n" + kSimulateCommandFreePorts +
                         "  gripper: {port: 0, rtu: true, wire_faults: {bad_crc: -1}}\n"
                         "  force_torque: {port: 0, command_port: 0}\n");
  EXPECT_EQ(run("doctor --cell both.yaml").code, 6);
}

}  // namespace
}  // namespace stonestack
