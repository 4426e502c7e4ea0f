// Guarded motions of the UR backend with the force sensor's own backend: what users report of such sensors,
// an offset after a power cycle, drift and single wild readings, neither ends a descent nor hides a contact.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "emulators/robotiq/ft_simulator.hpp"
#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/robotiq/ft_sensor.hpp"
#include "hardware/ur/ur_arm.hpp"
#include "motion/timing.hpp"
#include "script_bench.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

using Status = MotionResult::Status;

constexpr double kOffset = 40.0;  // N, of a sensor that has forgotten its zero; eight times the threshold

struct ForceOnTheWireBench {
  RobotModel robot = read_robot("ur10");
  IdealPlant joints{ScriptBench::start()};
  IdealWrenchPlant wrist;
  UrControllerServer server{UrServerOptions{}, robot, joints};
  std::unique_ptr<FtSimulator> simulator;
  std::unique_ptr<RobotiqFtSensor> sensor;
  std::unique_ptr<UrArm> arm;

  explicit ForceOnTheWireBench(int contact_samples = 2) {
    server.start();
    push(0.0);
    FtSimulatorOptions served;
    served.serial = false;
    served.cap = true;
    served.port = served.command_port = 0;
    simulator = std::make_unique<FtSimulator>(wrist, served);
    FtSensorOptions client;
    client.link = "ur_cap";
    client.port = simulator->stream_endpoint().port;
    client.stale = 1.0;  // other programs share this machine with the test
    sensor = std::make_unique<RobotiqFtSensor>(client);
    UrArmOptions o;
    o.address = "127.0.0.1";
    o.rtde_port = server.ports().rtde;
    o.primary_port = server.ports().primary;
    o.secondary_port = server.ports().secondary;
    o.realtime_port = server.ports().realtime;
    o.dashboard_port = server.ports().dashboard;
    o.rtde.stale_after = o.script.force_stale = 1.0;
    o.script.heartbeat_rate = 2;
    o.script.contact_samples = contact_samples;
    arm = std::make_unique<UrArm>(robot, o, Pose::Identity(), Pose(Eigen::Translation3d(0, 0, 0.264)),
                                  sensor.get());
  }
  /// Presses the gripper upwards, N, on top of the sensor's offset in the same direction.
  void push(double force) {
    const Eigen::Matrix3d R_F_R = forward(robot, ScriptBench::start()).rotation().transpose();
    Wrench wrench;
    wrench.force = R_F_R * Eigen::Vector3d(0, 0, kOffset + force);
    wrist.set(wrench);
  }
  /// A slow turn of one joint that hardly turns the gripper; `meanwhile` happens half a second after its
  /// start.
  template <class Meanwhile>
  MotionResult descend(const Meanwhile& meanwhile) {
    TimingLimits limits;
    limits.velocity.setConstant(0.05);
    limits.acceleration.setConstant(0.5);
    Joints goal = arm->state().q;
    goal[0] += 0.10;
    GuardedMotion motion;
    motion.trajectory = time_path({arm->state().q, goal}, limits);
    std::thread fate([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(700));
      meanwhile();
    });
    const MotionResult result = arm->follow_guarded(motion);
    fate.join();
    return result;
  }
};

TEST(ForceOnTheWire, OffsetAndDriftAreNoContact) {
  ForceOnTheWireBench bench;
  FtFaults drifting;
  drifting.drift = 0.5;
  bench.simulator->set_faults(drifting);
  EXPECT_GT(bench.sensor->read().force.norm(), kOffset - 1.0);
  MotionResult moved = bench.descend([] {});
  EXPECT_EQ(moved.status, Status::kNoContact) << moved.reason;
  moved = bench.descend([&] { bench.push(9.0); });
  EXPECT_EQ(moved.status, Status::kContact) << moved.reason << ": drift does not hide it either";
  EXPECT_NEAR(moved.force, 9.0, 1.5) << "what has come since the descent began, drift and all";
}

TEST(ForceOnTheWire, OneWildReadingIsNoContact) {
  const auto descend_with_wild_readings = [](int contact_samples) {
    ForceOnTheWireBench bench(contact_samples);
    return bench
        .descend([&] {
          for (int k = 0; k < 5; ++k) {
            FtFaults wild;
            wild.spike = -80.0;  // the gripper points down: upwards is along -z of the sensor
            bench.simulator->set_faults(wild);
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
          }
        })
        .status;
  };
  EXPECT_EQ(descend_with_wild_readings(2), Status::kNoContact);
  EXPECT_EQ(descend_with_wild_readings(1), Status::kContact) << "two readings running are what keeps it out";
}

}  // namespace
}  // namespace stonestack::emulators
