// Gripper, force sensor and camera of the simulated cell through their real protocols.
#include <gtest/gtest.h>

#include <algorithm>

#include "emulators/camera/camera_simulator.hpp"
#include "emulators/robotiq/ft_simulator.hpp"
#include "emulators/robotiq/gripper_simulator.hpp"
#include "emulators/servers_options.hpp"
#include "hardware/camera/stream_camera.hpp"
#include "hardware/robotiq/ft_sensor.hpp"
#include "hardware/robotiq/three_finger_gripper.hpp"
#include "hardware/ur/rtde_client.hpp"
#include "simulation/pebble.hpp"
#include "simulation/shared_world.hpp"
#include "stonestack/emulators/simulated_servers.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kSpeed = 5.0;  // times real time

/// A pebble on the table, the open gripper over it, time passing by itself.
struct Bench {
  std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  SimulationOptions options;
  SimulatedCell cell;
  SharedWorld& world;

  explicit Bench(bool noise = false)
      : options(quiet(noise)),
        cell(stones, {0_stone}, read_robot("ur10"), {}, options),
        world(cell.shared()) {
    auto access = world.lock();
    Pose T_W_O = Pose::Identity();
    double lowest = 0;
    for (const auto& p : access.world.shapes()[0]->scan.vertices) lowest = std::min(lowest, p.z());
    T_W_O.translation().z() = 0.0005 - lowest;
    GripperPose gripper_pose{tool_down({0, 0, 0.5}), {}};
    gripper_pose.finger.fill(0.0775);
    access.world.set_gripper_pose(gripper_pose);
    access.world.place(0_stone, T_W_O);
  }
  static SimulationOptions quiet(bool noise) {
    SimulationOptions options;
    options.sensor_noise = noise;
    return options;
  }
  void put_tool(const Eigen::Vector3d& p_W) const { (void)world.move_arm(tool_down(p_W), 1.0); }
};

struct GripperBench : Bench {
  std::unique_ptr<GripperPlant> plant = make_world_gripper(world);
  std::unique_ptr<GripperSimulator> simulator;
  std::unique_ptr<ThreeFingerGripper> gripper;

  GripperBench() {
    GripperSimulatorOptions served;
    served.port = 0;
    served.speed_up = kSpeed;
    simulator = std::make_unique<GripperSimulator>(*plant, served);
    world.start(kSpeed);
    ThreeFingerOptions client;
    client.modbus.port = simulator->endpoint().port;
    client.modbus.reply_timeout = 2.0;
    client.move_margin = 100.0;  // with a sanitizer on a busy machine, time here passes slowly
    client.activation_timeout = 100.0;
    gripper = std::make_unique<ThreeFingerGripper>(client);
    gripper->activate();
  }
  ~GripperBench() { world.stop(); }
};

TEST(DevicesInTheWorld, TheGripperHoldsAStoneOverModbus) {
  GripperBench bench;
  EXPECT_FALSE(bench.gripper->move(0.155, 0.11, 15).object);
  bench.world.stop();
  bench.put_tool({0, 0, 0.015});
  bench.world.start(kSpeed);
  const GripperState held = bench.gripper->move(0.0, 0.05, 60.0);
  EXPECT_TRUE(held.object);
  EXPECT_GT(held.opening, 0.03);
  bench.world.stop();
  const auto gripper_pose = bench.world.lock().world.gripper_pose();
  EXPECT_NEAR(held.opening, opening(gripper_pose), 0.001) << "Modbus reports the true finger positions";
  bench.put_tool({0, 0, 0.25});
  EXPECT_GT(bench.world.lock().world.centre_of_mass(0_stone).z(), 0.2) << "the stone comes along";
  bench.world.start(kSpeed);
  EXPECT_TRUE(bench.gripper->state().object);
}

TEST(DevicesInTheWorld, OpenFingersStandAtTheSoftwareLimit) {
  GripperBench bench;
  const GripperState open = bench.gripper->move(0.155, 0.11, 15);
  const ThreeFingerStatus status = bench.gripper->status();
  for (std::size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(status.axes[f].request, 0);
    EXPECT_NEAR(status.axes[f].position, 6, 1) << "Robotiq's manual: 6 to 7";
  }
  bench.world.stop();
  EXPECT_NEAR(open.opening, opening(bench.world.lock().world.gripper_pose()), 0.001);
}

// A force where nothing touches is a contact to UR's client library (its script asks tool_contact at rest).
TEST(DevicesInTheWorld, TheArmsInstallationKnowsItsGripper) {
  const std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  const RobotModel robot = read_robot("ur10");
  SimulatedCell cell(stones, {0_stone}, robot, {}, Bench::quiet(false));
  SimulatedServersOptions served;
  served.devices = {true, false, false, false};
  const SimulatedServers servers(cell, robot, served);
  const auto recipe = [](const UrVersion&) {
    return RtdeRecipe{{"payload", "payload_cog", "actual_TCP_force"}, {}, {}};
  };
  RtdeOptions patient;
  patient.stale_after = patient.silent_after = 30.0;
  const RtdeClient client({served.arm.address, servers.arm_ports().rtde}, recipe, patient);
  const auto sample = client.wait_for_next(Deadline::in(30.0));
  ASSERT_TRUE(sample);
  EXPECT_NEAR(sample->get<double>("payload"), 3.35, 1e-9) << "gripper, force sensor and camera";
  EXPECT_NEAR((sample->get<std::array<double, 3>>("payload_cog")[2]), 0.264 - 0.12, 0.05);
  for (const double value : sample->get<std::array<double, 6>>("actual_TCP_force"))
    EXPECT_NEAR(value, 0.0, 0.05);
}

TEST(DevicesInTheWorld, AGripperAloneMoves) {
  const std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  const RobotModel robot = read_robot("ur10");
  SimulatedCell cell(stones, {0_stone}, robot, {}, Bench::quiet(false));
  SimulatedServersOptions served;
  served.devices = {false, true, false, false};
  served.gripper.port = 0;
  served.gripper.speed_up = served.arm.speed = kSpeed;
  const SimulatedServers servers(cell, robot, served);
  EXPECT_EQ(servers.arm_ports().rtde, 0);
  EXPECT_FALSE(servers.force_torque() || servers.camera());
  EXPECT_EQ(servers.gripper_line(), "");
  const std::string text = servers.text();
  EXPECT_EQ(text.rfind("gripper ", 0), 0U) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  ThreeFingerOptions client;
  client.modbus.port = servers.gripper()->port;
  client.modbus.reply_timeout = 2.0;
  client.move_margin = client.activation_timeout = 100.0;
  ThreeFingerGripper gripper(client);
  gripper.activate();
  EXPECT_NEAR(gripper.move(0.05, 0.11, 30).opening, 0.05, 0.001);
}

TEST(DevicesInTheWorld, ClosingUponNothingIsNoObject) {
  GripperBench bench;
  const GripperState state = bench.gripper->move(0.02, 0.11, 60.0);
  EXPECT_FALSE(state.object);
  EXPECT_NEAR(state.opening, 0.02, 0.001);
}

TEST(DevicesInTheWorld, TheSensorMeasuresTheGripperAndTaresIt) {
  Bench bench;
  const auto plant = make_world_wrench(bench.world);
  FtSimulatorOptions served;
  const FtSimulator simulator(*plant, served);
  FtSensorOptions client;
  client.device = simulator.serial_path();
  client.stale = 2.0;
  client.start_timeout = 20.0;
  client.stuck_samples = 0;  // no noise: every reading is the same
  RobotiqFtSensor sensor(client);
  const double weight = 9.81 * sensed_mass(bench.world.lock().world.gripper_body().gripper);
  EXPECT_NEAR(sensor.read().force.norm(), weight, 0.05);
  sensor.zero();
  EXPECT_NEAR(sensor.read().force.norm(), 0.0, 0.05);
}

TEST(DevicesInTheWorld, TheCameraSeesTheTableWhereItIs) {
  Bench bench(true);
  const auto plant = make_world_depth(bench.world);
  const CameraSimulator simulator(*plant);
  bench.world.start(kSpeed);
  StreamCameraOptions client;
  client.port = simulator.endpoint().port;
  client.frame_timeout = 30.0;
  StreamCamera camera(client);
  const DepthFrame first = camera.capture(), second = camera.capture();
  bench.world.stop();
  EXPECT_GE(second.device_time, first.device_time + 1.0 / 30.0 - 1e-6);
  const Pose T_W_C = bench.world.lock().world.gripper_pose().T_W_T * bench.world.mounting().T_T_C;
  const Cloud cloud = transformed(without_gaps(to_cloud(first.image)), T_W_C);
  ASSERT_GT(cloud.points.size(), 100000U);
  const auto on_table = std::count_if(cloud.points.begin(), cloud.points.end(),
                                      [](const Eigen::Vector3f& p) { return std::abs(p.z()) < 0.01F; });
  EXPECT_GT(static_cast<double>(on_table), 0.8 * static_cast<double>(cloud.points.size()));
}

}  // namespace
}  // namespace stonestack::emulators
