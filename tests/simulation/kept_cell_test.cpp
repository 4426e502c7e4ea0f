#include <gtest/gtest.h>

#include <filesystem>

#include "cell_bench.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

/// A simulated cell that another process goes on with.
namespace stonestack::simulation {
namespace {

using Status = MotionResult::Status;

std::string kept_folder(const std::string& name) {
  return test::temporary_folder() + name;
}

/// A cell that goes on from what `bench` has kept.
SimulatedCell gone_on(const CellBench& bench, const std::string& folder,
                      const SimulationOptions& options = {}) {
  return SimulatedCell(bench.stones, first_stones(bench.stones.size()), bench.robot, bench.layout, options,
                       folder);
}

TEST(KeptCell, AStoneInTheGripperIsStillHeldAndCarried) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const std::string folder = kept_folder("held");
  bench.simulated.keep_in(folder);
  const Eigen::Vector3d p = bench.centre(0_stone);
  const double yaw = bench.yaw(0_stone);
  ASSERT_TRUE(bench.grasp(0_stone).object);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), 0.2}, yaw), 0.1).status, Status::kDone);

  SimulatedCell other = gone_on(bench, folder);
  Cell cell = other.cell();
  EXPECT_TRUE(cell.gripper.state().object);
  EXPECT_EQ(cell.arm.state().q, bench.cell.arm.state().q);
  EXPECT_DOUBLE_EQ(other.truth().time, bench.simulated.truth().time);
  EXPECT_EQ(other.truth().T_W_O[0].matrix(), bench.simulated.truth().T_W_O[0].matrix());
  other.wait(2.0);
  EXPECT_LT(difference(other.truth().T_W_O[0], bench.simulated.truth().T_W_O[0]).translation, 0.0005)
      << "it does not slip while nothing moves";
  const JointTrajectory carry = bench.line(tool_down({p.x(), p.y() + 0.1, 0.25}, yaw), 0.25);
  ASSERT_EQ(cell.arm.follow(carry).status, Status::kDone);
  EXPECT_TRUE(cell.gripper.state().object);
  const Eigen::Vector3d carried =
      other.truth().T_W_O[0].translation() - bench.simulated.truth().T_W_O[0].translation();
  EXPECT_LT((carried - Eigen::Vector3d(0, 0.1, 0.05)).norm(), 0.005);
}

TEST(KeptCell, DrawsGoOnWhereTheyWere) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const std::string folder = kept_folder("draws");
  bench.simulated.keep_in(folder);
  ASSERT_EQ(bench.go(tool_down({0.7, 0.2, 0.4})).status, Status::kDone);
  SimulatedCell other = gone_on(bench, folder);
  const JointTrajectory on = bench.line(tool_down({0.7, 0.1, 0.4}), 0.25);
  for (Arm* arm : {&bench.cell.arm, &other.cell().arm}) ASSERT_EQ(arm->follow(on).status, Status::kDone);
  EXPECT_EQ(other.cell().camera.capture().image.z, bench.cell.camera.capture().image.z)
      << "noise of camera and arm";
}

TEST(KeptCell, AMotionIsKeptOnItsWay) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const std::string folder = kept_folder("on_its_way");
  bench.simulated.keep_in(folder);
  const Joints start = bench.cell.arm.state().q;
  const JointTrajectory slow = bench.line(tool_down({0.7, 0.2, 0.4}), 0.05);
  std::filesystem::remove_all(folder);
  EXPECT_THROW((void)bench.cell.arm.follow(slow), FileError) << "it is written long before the end";
  bench.simulated.keep_in(folder);
  SimulatedCell other = gone_on(bench, folder);
  const Joints q = other.cell().arm.state().q;
  EXPECT_GT((q - start).norm(), 1e-5);
  EXPECT_GT((q - slow.q.back()).norm(), 0.01);
  EXPECT_EQ(other.cell().arm.follow(bench.line(tool_down({0.7, 0.2, 0.4}), 0.25)).status, Status::kDone);
}

TEST(KeptCell, ADamagedFileIsRefused) {
  CellBench bench({make_pebble("pebble", 1.2)});
  const std::string folder = kept_folder("damaged"), path = folder + "/simulated-cell/world.json";
  EXPECT_THROW((void)gone_on(bench, folder), FileError) << "nothing is kept there";
  bench.simulated.keep_in(folder);
  EXPECT_NO_THROW((void)gone_on(bench, folder));
  const std::string whole = read_file(path, 1 << 24);
  for (const std::string& content : {whole.substr(0, whole.size() / 2), std::string("{}"),
                                     std::string(R"({"schema": "stonestack.simulated_cell/9"})")}) {
    write_file(path, content);
    EXPECT_THROW((void)gone_on(bench, folder), FileError) << content.substr(0, 80);
  }
  write_file(path, whole);
  bench.stones[0].name = "another";
  EXPECT_THROW((void)gone_on(bench, folder), FileError) << "other stones lie there";
}

}  // namespace
}  // namespace stonestack::simulation
