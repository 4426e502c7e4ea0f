#include "stonestack/simulation/simulated_cell.hpp"

#include <gtest/gtest.h>

#include "cell_bench.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

using Status = MotionResult::Status;

TEST(SimulatedCell, PicksCarriesFeelsContactAndReleases) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const auto& [arm, gripper, force_torque, camera, clock, layout] = bench.cell;
  const Eigen::Vector3d p = bench.centre(0_stone);
  const double yaw = bench.yaw(0_stone), low = std::max(0.004, p.z() - 0.015);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), 0.25}, yaw)).status, Status::kDone);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), low}, yaw), 0.1).status, Status::kDone);
  const double z_before = force_torque.read().force.z();
  ASSERT_TRUE(gripper.move(0.0, 0.05, 60.0).object);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), 0.2}, yaw), 0.1).status, Status::kDone);
  // The flange's z points down: the stone pulls along +z.
  double weight = 0;
  for (int i = 0; i < 50; ++i) weight += (force_torque.read().force.z() - z_before) / 50;
  const double expected = 9.81 * bench.stones[0].mass.mass;
  EXPECT_NEAR(weight, expected, 0.03 * expected + 0.06 * expected) << "6 % for the true mass";

  const Eigen::Vector2d goal(0.7, 0.2);
  ASSERT_EQ(bench.go(tool_down({goal.x(), goal.y(), 0.2}, yaw)).status, Status::kDone);
  ASSERT_EQ(bench.go(tool_down({goal.x(), goal.y(), low + 0.02}, yaw)).status, Status::kDone);
  force_torque.zero();
  const auto contact =
      arm.follow_guarded({bench.line(tool_down({goal.x(), goal.y(), low - 0.010}, yaw), 0.005)});
  EXPECT_EQ(contact.status, Status::kContact) << contact.reason;
  EXPECT_LT(contact.force, 30.0);
  EXPECT_NEAR(bench.centre(0_stone).z(), p.z(), 0.002);
  const Eigen::Vector3d set_down = bench.centre(0_stone);
  EXPECT_NEAR(gripper.move(0.155, 0.03, 15.0).opening, 0.155, 1e-6);
  ASSERT_EQ(bench.go(tool_down({goal.x(), goal.y(), 0.25}, yaw), 0.1).status, Status::kDone);
  bench.simulated.wait(2.0);
  EXPECT_LT((bench.centre(0_stone) - set_down).norm(), 0.01);
  EXPECT_LT((bench.centre(0_stone).head<2>() - goal).norm(), 0.02);
}

TEST(SimulatedCell, ACarryEndsWhereItsStoneIsLost) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const Eigen::Vector3d p = bench.centre(0_stone);
  const double yaw = bench.yaw(0_stone);
  ASSERT_TRUE(bench.grasp(0_stone).object);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), 0.25}, yaw), 0.1).status, Status::kDone);
  const auto there = bench.line(tool_down({p.x(), p.y() + 0.2, 0.25}, yaw), 0.2);
  ASSERT_EQ(bench.cell.arm.carry(there).status, Status::kDone) << "it is held";
  Pose T_W_O = bench.simulated.truth().T_W_O[0];
  T_W_O.translation() = Eigen::Vector3d(0.5, -0.4, 0.06);
  bench.simulated.place(0_stone, T_W_O);  // taken out of the gripper
  const auto back = bench.line(tool_down({p.x(), p.y(), 0.25}, yaw), 0.1);
  const MotionResult lost = bench.cell.arm.carry(back);
  EXPECT_EQ(lost.status, Status::kDropped) << lost.reason;
  EXPECT_LT((bench.T_W_T(lost.q).translation() - bench.T_W_T(back.q.front()).translation()).norm(), 0.1)
      << "at rest early in the two seconds";
  EXPECT_TRUE(bench.cell.arm.state().can_move) << "no stop of the safety system";
  EXPECT_EQ(bench.go(tool_down({p.x(), p.y(), 0.3}, yaw)).status, Status::kDone);
}

TEST(SimulatedCell, ItsArmRefusesWhatTheDriverOfARealOneRefuses) {
  const std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  const auto turned = [&](const RobotModel& robot, double seconds) {
    SimulatedCell simulated(stones, {0_stone}, robot, CellLayout{});
    const Joints q = simulated.cell().arm.state().q;
    Joints there = q;
    there[0] += 0.2;
    return simulated.cell().arm.follow({{0.0, seconds}, {q, there}, {Joints::Zero(), Joints::Zero()}});
  };
  RobotModel robot = ur10();
  const MotionResult free = turned(robot, 2.0);
  ASSERT_EQ(free.status, Status::kDone) << free.reason;
  const MotionResult hard = turned(robot, 0.5);  // 6 * 0.2 / 0.5^2 = 4.8 rad/s^2
  EXPECT_EQ(hard.status, Status::kRefused);
  EXPECT_NE(hard.reason.find("joint 1 changes its speed"), std::string::npos) << hard.reason;
  robot.tool_speed = 0.05;  // 1.5 * 0.2 / 2 = 0.15 rad/s, more than half a metre from the axis
  const MotionResult fast = turned(robot, 2.0);
  EXPECT_EQ(fast.status, Status::kRefused);
  EXPECT_NE(fast.reason.find("limits.tool_speed"), std::string::npos) << fast.reason;
  robot = ur10();
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(5.0);
  robot.fence = ArmFence{{-far, far}, Pose::Identity(), {}};
  EXPECT_EQ(turned(robot, 2.0).status, Status::kDone);
  robot.fence->box.max().z() = link_poses(robot, free.q)[3].translation().z() - 0.02;  // the elbow's height
  const MotionResult out = turned(robot, 2.0);
  EXPECT_EQ(out.status, Status::kRefused);
  EXPECT_NE(out.reason.find("leaves the fence"), std::string::npos) << out.reason;
}

TEST(SimulatedCell, GuardedDescentStopsAtOnceOnTheTable) {
  CellBench bench({make_pebble("pebble", 1.2)});
  ASSERT_EQ(bench.go(tool_down({0.7, 0.3, 0.02})).status, Status::kDone);
  const auto contact = bench.cell.arm.follow_guarded({bench.line(tool_down({0.7, 0.3, -0.02}), 0.005)});
  EXPECT_EQ(contact.status, Status::kContact);
  EXPECT_LT(contact.force, 30.0);
  EXPECT_NEAR(bench.T_W_T(contact.q).translation().z(), 0.0, 0.003);
  ASSERT_EQ(bench.go(tool_down({0.7, 0.3, 0.02})).status, Status::kDone);
  const auto nothing = bench.cell.arm.follow_guarded(
      {bench.line(tool_down({0.7, 0.3, 0.05}), 0.02), Eigen::Vector3d::UnitZ()});
  EXPECT_EQ(nothing.status, Status::kNoContact);
}

TEST(SimulatedCell, ALateForceLetsTheGripperPressHarder) {
  const auto height_at_contact = [](double delay) {
    SimulationOptions options;
    options.force_delay = delay;
    CellBench bench({make_pebble("pebble", 1.2)}, options);
    EXPECT_EQ(bench.go(tool_down({0.7, 0.3, 0.02})).status, Status::kDone);
    const auto contact = bench.cell.arm.follow_guarded({bench.line(tool_down({0.7, 0.3, -0.02}), 0.005)});
    EXPECT_EQ(contact.status, Status::kContact);
    return bench.T_W_T(contact.q).translation().z();
  };
  // 20 ms at about 5 mm/s.
  EXPECT_NEAR(height_at_contact(0.0) - height_at_contact(0.020), 0.0001, 0.00006);
}

TEST(SimulatedCell, EveryStateHasTheTimeOfTheCellsClock) {
  CellBench bench({make_pebble("pebble", 1.2)});
  bench.cell.force_torque.zero();  // takes its time
  const double before = bench.cell.clock.now();
  ASSERT_GT(before, 0.0);
  EXPECT_GE(bench.cell.force_torque.read().host_time, before);
  EXPECT_GE(bench.cell.gripper.state().host_time, before);
  EXPECT_GE(bench.cell.arm.state().host_time, before);
  EXPECT_GE(bench.cell.camera.capture().host_time, before);
}

TEST(SimulatedCell, ArmRefusesAndStops) {
  CellBench bench({make_pebble("pebble", 1.2)});
  auto& arm = bench.cell.arm;
  auto elsewhere = bench.line(tool_down({0.7, 0.1, 0.4}), 0.2);
  for (auto& q : elsewhere.q) q[0] += 0.05;
  EXPECT_EQ(arm.follow(elsewhere).status, Status::kRefused);
  auto broken = bench.line(tool_down({0.7, 0.1, 0.4}), 0.2);
  broken.q.back()[3] = std::nan("");
  EXPECT_EQ(arm.follow(broken).status, Status::kRefused);
  auto fast = bench.line(tool_down({0.7, 0.3, 0.4}), 0.2);
  for (auto& t : fast.time) t *= 0.05;
  for (auto& qd : fast.qd) qd *= 20;
  const auto refused = arm.follow(fast);
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_NE(refused.reason.find("rad/s, limit"), std::string::npos) << refused.reason;
  const auto stopped = arm.follow(bench.line(tool_down({0.7, 0.2, -0.05}), 0.2));  // into the table
  EXPECT_EQ(stopped.status, Status::kStopped);
  EXPECT_FALSE(arm.state().can_move);
  EXPECT_EQ(arm.follow(bench.line(tool_down({0.7, 0.1, 0.4}), 0.2)).status, Status::kRefused);
  bench.simulated.unlock();
  EXPECT_TRUE(arm.state().can_move);
  EXPECT_NE(arm.follow(bench.line(tool_down({0.7, 0.1, 0.4}), 0.2)).status, Status::kRefused)
      << "pressed onto the table it may stop again";
}

TEST(SimulatedCell, ArmKeepsTheWorkspaceOfTheCell) {
  CellBench bench({make_pebble("pebble", 1.2)});
  RobotModel robot = bench.robot;
  robot.workspace = ToolWorkspace{
      {Eigen::Vector3d(-2, -2, 0.2), Eigen::Vector3d(2, 2, 2)}, bench.layout.T_W_R, bench.layout.T_F_T};
  SimulatedCell kept(bench.stones, {0_stone}, robot, bench.layout, {});
  Arm& arm = kept.cell().arm;
  const auto low = arm.follow(bench.line(tool_down({0.7, 0.1, 0.1}), 0.2));
  EXPECT_EQ(low.status, Status::kRefused);
  EXPECT_NE(low.reason.find("leaves the workspace"), std::string::npos) << low.reason;
  EXPECT_EQ(arm.follow(bench.line(tool_down({0.7, 0.1, 0.4}), 0.2)).status, Status::kDone);
}

TEST(SimulatedCell, StonesLieApartInTheFieldAndTheCameraSeesThem) {
  std::vector<Stone> stones;
  for (int i = 0; i < 5; ++i) stones.push_back(make_pebble("pebble_" + std::to_string(i), 0.5 + 0.3 * i));
  CellBench bench(stones);
  const auto truth = bench.simulated.truth();
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d p = bench.centre(StoneIndex(i));
    EXPECT_LT(std::abs(p.x() - bench.layout.field_centre.x()), 0.5 * bench.layout.field_size.x() + 1e-3);
    EXPECT_LT(std::abs(p.y() - bench.layout.field_centre.y()), 0.5 * bench.layout.field_size.y() + 1e-3);
    for (int j = 0; j < i; ++j) EXPECT_GT((p - bench.centre(StoneIndex(j))).head<2>().norm(), 0.09);
  }
  for (const auto& contact : truth.contacts) EXPECT_EQ(contact.below, kTable);
  const auto first = bench.cell.camera.capture(), second = bench.cell.camera.capture();
  EXPECT_LT(first.number, second.number);
  EXPECT_LT(first.device_time, second.device_time);
  // At each stone's place in the image something stands out from the table.
  const Pose T_C_W = (bench.T_W_T(bench.cell.arm.state().q) * bench.layout.T_T_C).inverse();
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d p_C = T_C_W * bench.centre(StoneIndex(i));
    const Eigen::Vector2d uv = project(first.image.camera, p_C);
    const int u = static_cast<int>(uv.x()), v = static_cast<int>(uv.y());
    ASSERT_TRUE(u > 5 && v > 5 && u < 635 && v < 475) << "stone " << i << " out of view";
    double nearest = 10;
    for (int dv = -3; dv <= 3; ++dv)
      for (int du = -3; du <= 3; ++du)
        if (const float z = first.image.at(u + du, v + dv); z > 0) nearest = std::min<double>(nearest, z);
    EXPECT_LT(nearest, p_C.z() - 0.01) << "stone " << i;
  }
}

TEST(SimulatedCell, ACameraMountedStraightDoesNotSeeItself) {
  CellLayout layout;
  layout.T_T_C = Pose(Eigen::Translation3d(0.0, 0.11, -0.17));  // its box, along T's axes, holds the lens
  CellBench bench({make_pebble("pebble", 1.2)}, {}, layout);
  const DepthImage image = bench.cell.camera.capture().image;
  const auto seen = std::count_if(image.z.begin(), image.z.end(), [](float z) { return z > 0.0F; });
  EXPECT_GT(seen, static_cast<std::ptrdiff_t>(image.z.size() / 2));
}

TEST(SimulatedCell, TooManyStonesAreRefusedWithAReason) {
  const std::vector<Stone> stones(3, make_pebble("boulder", 3.0));
  CellLayout tight;
  tight.field_size = {0.10, 0.10};
  EXPECT_THROW(SimulatedCell(stones, first_stones(3), read_robot("ur10"), tight), InvalidArgument);
}

TEST(SimulatedCell, SameSeedSameStonesSameImage) {
  const std::vector<Stone> stones{make_pebble("a", 0.6), make_pebble("b", 1.0)};
  CellBench first(stones), again(stones);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_TRUE((first.simulated.truth().T_W_O[i].matrix().array() ==
                 again.simulated.truth().T_W_O[i].matrix().array())
                    .all());
  EXPECT_EQ(first.cell.camera.capture().image.z, again.cell.camera.capture().image.z);
  const auto pose = tool_down({0.7, 0.1, 0.3});
  EXPECT_EQ(first.go(pose).q, again.go(pose).q);
  EXPECT_EQ(first.cell.force_torque.read().force, again.cell.force_torque.read().force);
}

TEST(SimulatedCell, WaitingLetsThatMuchTimePassAndStonesRest) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const double begin = bench.cell.clock.now();
  const Pose before = bench.simulated.truth().T_W_O[0];
  bench.simulated.wait(10.0);
  EXPECT_NEAR(bench.cell.clock.now() - begin, 10.0, 0.002);
  const PoseDifference moved = difference(bench.simulated.truth().T_W_O[0], before);
  EXPECT_LT(moved.translation, 1e-4);
  EXPECT_LT(moved.angle, 1e-3);
}

}  // namespace
}  // namespace stonestack::simulation
