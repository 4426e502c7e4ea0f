// The force sensor in the flange of a simulated e-Series arm: what its controller reports, worked out on
// paper, and what the driver of the arm makes of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "emulators/ur/controller.hpp"
#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/ur/ur_arm.hpp"
#include "hardware/ur/ur_force_torque.hpp"
#include "motion/timing.hpp"
#include "simulation/pebble.hpp"
#include "simulation/shared_world.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

using testing::HasSubstr;
using Status = MotionResult::Status;

constexpr const char* kPolyScope = "5.12.2.1101534";
constexpr double kG = 9.81;  // m/s^2

UrServerOptions e_series() {
  UrServerOptions options;
  options.version = kPolyScope;
  options.model = "UR10e";
  return options;
}

/// A UR10e whose flange looks down: x of F along x of R, y and z against theirs.
struct DownwardBench {
  RobotModel robot = read_robot("ur10e");
  IdealPlant plant{joints()};
  UrController controller{e_series(), robot, plant};

  static Joints joints() {
    constexpr double kRight = 1.57079632679489661923;
    return (Joints() << kRight, -kRight, kRight, -kRight, -kRight, 0.0).finished();
  }
  void run(double seconds) {
    for (double t = 0; t < seconds; t += controller.period()) controller.step();
  }
  void run(const std::string& body) {
    controller.run_script("def p():\n" + body + "\nend\n");
    for (int k = 0; k < 20000 && controller.runtime() != RuntimeState::kStopped; ++k) controller.step();
    run(0.01);
  }
};

Six six_of(double fx, double fy, double fz, double mx, double my, double mz) {
  return (Six() << fx, fy, fz, mx, my, mz).finished();
}

// A gripper of 2 kg, its centre 0.1 m below the flange, and 3 N along x of R, 0.2 m below the flange.
TEST(OwnSensorController, ReportsBothWrenchesAsWorkedOutOnPaper) {
  DownwardBench bench;
  const Eigen::Matrix3d R_R_F = forward(bench.robot, DownwardBench::joints()).rotation();
  ASSERT_LT((R_R_F - Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()).norm(), 1e-6);
  bench.run(0.1);
  const Six nothing = bench.controller.raw_wrench();
  EXPECT_GT(nothing.head<3>().norm(), 2e4) << "the sensor's constant part";
  const double weight = 2.0 * kG;
  bench.plant.set_wrench({3.0, 0, -weight}, {0, -0.6, 0});  // (0, 0, -0.2) x (3, 0, 0)
  bench.run(0.1);
  const Six felt = bench.controller.raw_wrench() - nothing;
  EXPECT_LT((felt - six_of(3.0, 0, weight, 0, 0.6, 0)).norm(), 1e-6) << "axes of F";
  // In B, half a turn about z from R, about the flange, since it was switched on.
  EXPECT_LT((bench.controller.wrench() - six_of(-3.0, 0, -weight, 0, 0.6, 0)).norm(), 1e-6);

  bench.run("  set_payload(2.0, [0, 0, 0.1])\n  set_tcp(p[0, 0, 0.3, 0, 0, 0])");
  EXPECT_LT(bench.controller.wrench().norm(), 1e-9) << "set_payload zeroes the compensated one";
  EXPECT_LT((bench.controller.raw_wrench() - nothing - felt).norm(), 1e-9) << "and leaves the raw one alone";

  bench.plant.set_wrench({3.0, 0, -weight - kG}, {0, -0.6, 0});  // a stone of 1 kg
  bench.run(0.1);
  EXPECT_LT((bench.controller.wrench() - six_of(0, 0, -kG, 0, 0, 0)).norm(), 1e-6);
  EXPECT_NEAR((bench.controller.raw_wrench() - nothing)[2], weight + kG, 1e-6);
  bench.run("  sync()");
  EXPECT_LT(bench.controller.wrench().norm(), 1e-9) << "a program that starts zeroes it, too";
  EXPECT_NEAR((bench.controller.raw_wrench() - nothing)[2], weight + kG, 1e-6);
  bench.plant.set_wrench(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  bench.run(0.1);
  EXPECT_LT((bench.controller.wrench() - six_of(3.0, 0, weight + kG, 0, -0.6, 0)).norm(), 1e-6);
  bench.run("  zero_ftsensor()");
  EXPECT_LT(bench.controller.wrench().norm(), 1e-9);
  EXPECT_LT((bench.controller.raw_wrench() - nothing).norm(), 1e-6);
}

TEST(OwnSensorController, LosesThePayloadsWeightInEveryPose) {
  DownwardBench bench;
  bench.plant.set_wrench({0, 0, -2.0 * kG}, Eigen::Vector3d::Zero());
  bench.run(0.1);
  const Six before = bench.controller.raw_wrench();
  bench.run(
      "  set_payload(2.0, [0, 0, 0])\n  q = get_actual_joint_positions()\n  q[3] = q[3] + 0.5\n  movej(q)");
  EXPECT_LT(bench.controller.wrench().norm(), 1e-6);
  EXPECT_NEAR((bench.controller.raw_wrench() - before).head<3>().norm(), 2.0 * kG * 2.0 * std::sin(0.25),
              1e-4)
      << "in F the weight turned by 0.5 rad";
}

TEST(OwnSensorController, ACb3EstimatesTheForceAtTheTool) {
  EXPECT_FALSE(has_own_sensor({}));
  EXPECT_TRUE(has_own_sensor(e_series()));
}

/// An ideal arm that a test thread presses, with noise of 0.01 N.
class PressedPlant final : public Plant {
 public:
  PlantState state() override { return ideal_.state(); }
  PlantState step(const Joints& q, double seconds) override {
    const std::lock_guard lock(mutex_);
    noise_ = noise_ > 3 ? -3 : noise_ + 1;
    ideal_.set_wrench(force_R_ + Eigen::Vector3d(0.003 * noise_, 0, 0), Eigen::Vector3d::Zero());
    return ideal_.step(q, seconds);
  }
  void press(const Eigen::Vector3d& force_R) {
    const std::lock_guard lock(mutex_);
    force_R_ = force_R;
  }

 private:
  std::mutex mutex_;
  IdealPlant ideal_{DownwardBench::joints()};
  Eigen::Vector3d force_R_ = Eigen::Vector3d::Zero();
  int noise_ = 0;
};

struct OwnSensorOnTheWire {
  RobotModel robot = read_robot("ur10e");
  PressedPlant plant;
  UrControllerServer server;
  UrArmOptions arm_options;
  FtSensorOptions sensor_options;

  explicit OwnSensorOnTheWire(const UrServerOptions& served = e_series()) : server(served, robot, plant) {
    server.start();
    UrArmOptions& o = arm_options;
    o.address = "localhost";
    o.rtde_port = server.ports().rtde;
    o.primary_port = server.ports().primary;
    o.secondary_port = server.ports().secondary;
    o.realtime_port = server.ports().realtime;
    o.dashboard_port = server.ports().dashboard;
    o.rtde.stale_after = o.script.force_stale = 1.0;
    o.script.heartbeat_rate = 2;
    o.rtde.attempts = 1;
    sensor_options.link = kOwnSensorLink;
    sensor_options.stale = 1.0;  // other programs share this machine with the test
    sensor_options.max_force = 100.0;
    sensor_options.max_torque = 10.0;
  }
  [[nodiscard]] UrForceTorque sensor() const { return UrForceTorque(arm_options, sensor_options); }
  [[nodiscard]] std::string problem() const {
    try {
      (void)sensor().read();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return {};
  }
};

/// Mean of readings that were taken after the call.
Eigen::Vector3d feel_now(UrForceTorque& sensor) {
  for (int k = 0; k < 5; ++k) (void)sensor.read();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int k = 0; k < 5; ++k) mean += sensor.read().force / 5;
  return mean;
}

// The weight of a stone is there whatever payload the arm was told of meanwhile, and programs ran.
TEST(OwnSensorOnTheWire, AStonesWeightOutlastsPayloadsAndPrograms) {
  OwnSensorOnTheWire bench;
  UrForceTorque sensor = bench.sensor();
  UrArm arm(bench.robot, bench.arm_options, Pose::Identity(), Pose(Eigen::Translation3d(0, 0, 0.223)),
            &sensor);
  bench.plant.press({0, 0, -2.7 * kG});
  arm.set_payload(2.7, {0, 0, 0.08});
  (void)feel_now(sensor);
  sensor.zero();
  EXPECT_LT(feel_now(sensor).norm(), 0.05);
  bench.plant.press({0, 0, -3.7 * kG});
  EXPECT_NEAR(feel_now(sensor).z(), kG, 0.05) << "F looks down";
  arm.set_payload(3.7, {0, 0, 0.12});
  EXPECT_NEAR(feel_now(sensor).z(), kG, 0.05);
  bench.plant.press({0, 0, -2.7 * kG});
  EXPECT_NEAR(feel_now(sensor).norm(), 0.0, 0.05) << "it was lost";
  bench.plant.press({0, 0, -200.0});
  EXPECT_THAT([&] { (void)feel_now(sensor); },
              testing::ThrowsMessage<DeviceError>(HasSubstr("beyond its range")));
}

TEST(OwnSensorOnTheWire, AGuardedMotionEndsAtItsThreshold) {
  OwnSensorOnTheWire bench;
  UrForceTorque sensor = bench.sensor();
  UrArm arm(bench.robot, bench.arm_options, Pose::Identity(), Pose(Eigen::Translation3d(0, 0, 0.223)),
            &sensor);
  bench.plant.press({0, 0, -30.0});
  arm.set_payload(2.7, {0, 0, 0.08});
  TimingLimits limits;
  limits.velocity.setConstant(0.05);
  limits.acceleration.setConstant(0.5);
  const auto descend = [&](double resistance) {
    Joints goal = arm.state().q;
    goal[0] += 0.10;
    GuardedMotion motion;
    motion.trajectory = time_path({arm.state().q, goal}, limits);
    std::thread fate([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(700));
      bench.plant.press({0, 0, -30.0 + resistance});
    });
    MotionResult result = arm.follow_guarded(motion);
    fate.join();
    bench.plant.press({0, 0, -30.0});
    return result;
  };
  const MotionResult light = descend(4.0);
  EXPECT_EQ(light.status, Status::kNoContact) << light.reason << ": 4 N are below the threshold of 5 N";
  const MotionResult touched = descend(9.0);
  EXPECT_EQ(touched.status, Status::kContact) << touched.reason;
  EXPECT_NEAR(touched.force, 9.0, 0.2);
}

TEST(OwnSensorOnTheWire, ASilentControllerIsAnError) {
  OwnSensorOnTheWire bench;
  bench.sensor_options.stale = 0.3;
  UrForceTorque sensor = bench.sensor();
  (void)sensor.read();
  bench.server.stop();
  EXPECT_THAT(
      [&] {
        for (int k = 0; k < 100; ++k) (void)sensor.read();
      },
      testing::ThrowsMessage<DeviceError>(testing::ContainsRegex("old|no new reading|link is down")));
}

TEST(OwnSensorOnTheWire, ControllersWithoutItAreRefused) {
  UrServerOptions served = e_series();
  served.version = "5.8.2.10297";
  EXPECT_THAT(OwnSensorOnTheWire(served).problem(), HasSubstr("PolyScope 5.9"));
  EXPECT_THAT(OwnSensorOnTheWire(UrServerOptions{}).problem(), HasSubstr("CB-series"));
  served = e_series();
  served.faults.missing_fields = "ft_raw_wrench";
  EXPECT_THAT(OwnSensorOnTheWire(served).problem(), HasSubstr("ft_raw_wrench"));
}

TEST(OwnSensorInTheWorld, FeelsAllThatHangsOnTheFlange) {
  for (const double mass : {0.0, 0.65}) {
    const std::vector<Stone> stones{make_pebble("pebble", 1.2)};
    const RobotModel robot = read_robot("ur10e");
    CellLayout layout;
    layout.sensor_mass = mass;
    layout.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.223));
    SimulationOptions options = options_of_cell("ideal");
    SimulatedCell cell(stones, {0_stone}, robot, layout, options);
    const Joints q = cell.cell().arm.state().q;
    EXPECT_FALSE(make_world_plant(cell.shared(), q)->step(q, 0.002).sensed) << "a CB3 has none";
    const PlantState state = make_world_plant(cell.shared(), q, true)->step(q, 0.002);
    ASSERT_TRUE(state.sensed);
    EXPECT_NEAR(state.force_R.norm(), kG * (2.5 + 0.2 + mass), 1e-6);
    EXPECT_LT((forward(robot, q).rotation() * state.sensed->force - state.force_R).norm(), 0.01);
  }
}

}  // namespace
}  // namespace stonestack::emulators
