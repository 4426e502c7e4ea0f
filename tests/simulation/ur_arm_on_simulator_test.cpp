// The UR backend against the simulated controller, over loopback sockets: neither knows the other's code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "script_bench.hpp"
#include "stonestack/hardware/ur/ur_arm.hpp"
#include "stonestack/motion/timing.hpp"

namespace stonestack {
namespace {

using ::testing::HasSubstr;
using Status = MotionResult::Status;

struct Pair {
  explicit Pair(const std::string& version, const ControllerFaults& faults = {})
      : server(server_options(version, faults), robot, plant) {
    server.start();
    UrArmOptions options;
    options.address = "127.0.0.1";
    options.rtde_port = server.ports().rtde;
    options.primary_port = server.ports().primary;
    options.secondary_port = server.ports().secondary;
    options.realtime_port = server.ports().realtime;
    options.dashboard_port = server.ports().dashboard;
    arm = std::make_unique<UrArm>(robot, options, Pose::Identity(), Pose::Identity());
  }
  static UrServerOptions server_options(const std::string& version, const ControllerFaults& faults) {
    return ScriptBench::options(version, faults);
  }
  [[nodiscard]] JointTrajectory way(double turn) const {
    Joints goal = ScriptBench::start();
    goal[0] += turn;
    goal[4] -= 0.5 * turn;
    TimingLimits limits;
    limits.velocity = Joints::Constant(0.8);
    limits.acceleration = Joints::Constant(1.2);
    return time_path({ScriptBench::start(), goal}, limits);
  }
  RobotModel robot = read_robot("ur10");
  IdealPlant plant{ScriptBench::start()};
  UrControllerServer server;
  std::unique_ptr<UrArm> arm;
};

class UrArmOnSimulator : public ::testing::TestWithParam<const char*> {};

TEST_P(UrArmOnSimulator, FollowsATrajectory) {
  Pair pair(GetParam());
  EXPECT_LT((pair.arm->state().q - ScriptBench::start()).norm(), 1e-9);
  const JointTrajectory way = pair.way(0.4);
  const MotionResult result = pair.arm->follow(way);
  EXPECT_EQ(result.status, Status::kDone) << result.reason;
  EXPECT_LT((result.q - way.q.back()).cwiseAbs().maxCoeff(), 0.003);
}

INSTANTIATE_TEST_SUITE_P(Versions, UrArmOnSimulator,
                         ::testing::Values("3.5.4.10845", "3.15.8.106339", "5.12.2.1101534"));

TEST(UrArmOnSimulator, ReportsAProtectiveStop) {
  Pair pair("3.15.8.106339");
  std::thread person([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    pair.server.protective_stop("hand in the way");
  });
  const MotionResult result = pair.arm->follow(pair.way(0.8));
  person.join();
  EXPECT_EQ(result.status, Status::kStopped) << result.reason;
  EXPECT_THAT(result.reason, HasSubstr("rotective"));
  EXPECT_FALSE(pair.arm->state().can_move);
}

TEST(UrArmOnSimulator, ReportsAProgramThatDies) {
  ControllerFaults faults;
  faults.script_dies_after = 0.3;
  Pair pair("3.15.8.106339", faults);
  const MotionResult result = pair.arm->follow(pair.way(0.8));
  EXPECT_EQ(result.status, Status::kStopped) << result.reason;
  EXPECT_THAT(result.reason, HasSubstr("runtime_error")) << "the controller's own words";
}

TEST(UrArmOnSimulator, RefusesWhatNeverStarts) {
  ControllerFaults faults;
  faults.scripts_never_start = true;
  Pair pair("3.15.8.106339", faults);
  const MotionResult result = pair.arm->follow(pair.way(0.3));
  EXPECT_EQ(result.status, Status::kRefused) << result.reason;
}

}  // namespace
}  // namespace stonestack
