// A dry run commands nothing: asked of the simulated devices on their wires, and in process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "emulators/servers_options.hpp"
#include "hardware/cell_config.hpp"
#include "hardware/read_only_devices.hpp"
#include "hardware/robotiq/three_finger_gripper.hpp"
#include "hardware/ur/joint_reader.hpp"
#include "hardware/ur/rtde_client.hpp"
#include "hardware/ur/ur_status.hpp"
#include "report/known_cells.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

using ::testing::HasSubstr;

class DryRun : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(order_.out); }
  void TearDown() override { std::filesystem::remove_all(order_.out); }
  DryRun() {
    order_.dry = true;
    order_.robot = read_robot("ur10");
    order_.per_run = 2;
    order_.run.seed = 3;
    spread_seed(order_.run);
    order_.out =
        test::temporary_folder() + "dry_run_" + testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  void expect_plan(const RecordedRun& done) const {
    const RunResult& result = done.report.result;
    EXPECT_EQ(result.end, RunEnd::kPlanned) << result.ended;
    EXPECT_THAT(result.ended, HasSubstr("place limestone_"));
    EXPECT_TRUE(result.placements.empty());
    ASSERT_GE(result.planned.size(), 6U);
    double fastest = 0.0, seconds = 0.0;
    for (const PlannedStep& step : result.planned) {
      fastest = std::max(fastest, step.tool_speed);
      seconds += step.seconds;
      EXPECT_TRUE(step.clearance || step.seconds == 0.0) << step.name;
    }
    EXPECT_GT(seconds, 5.0);
    EXPECT_GT(fastest, 0.1);
    EXPECT_LE(fastest, 1.001 * std::min(1.0, order_.speed == RunSpeed::kSlow ? kSlowToolSpeed : 1.0));
    for (const char* file : {"/result.json", "/report.html", "/journal.jsonl", "/tower.png", "/options.yaml"})
      EXPECT_TRUE(std::filesystem::exists(done.folder + file)) << file;
    const auto json = nlohmann::json::parse(read_file(done.folder + "/result.json", 1 << 20));
    EXPECT_EQ(json["ended"], "planned");
    EXPECT_EQ(json["planned"].size(), result.planned.size());
    EXPECT_THAT(run_table(done.report), HasSubstr(result.planned.front().name));
  }
  /// Simulated devices behind the sockets that `file` is led to.
  struct ServedCell {
    SimulatedCell world;
    SimulatedServers servers;
    ServedCell(const DryRun& test, CellFile& file)
        : world(test.catalogue_.stones,
                draw_stones(test.catalogue_, 2, 3, make_robotiq_3f(), test.order_.robot), test.order_.robot,
                true_layout(to_layout(file.cell()), file.servers()), test.order_.run.simulation),
          servers(world, test.order_.robot, file.servers()) {
      connect_to(servers, file.cell());
    }
  };
  RunOrder order_;
  Catalogue catalogue_ = read_catalogue(data_path("stones"));
};

TEST_F(DryRun, InTheSimulatedCellPlansTheFirstPlacement) {
  expect_plan(record_run(order_, catalogue_));
}

TEST_F(DryRun, PlansWithinTheSlowSpeed) {
  order_.speed = RunSpeed::kSlow;
  expect_plan(record_run(order_, catalogue_));
}

TEST_F(DryRun, CommandsNoDeviceOnTheWires) {
  CellFile file = read_cell(data_path("cells/loopback-ur10.yaml"));
  const ServedCell served(*this, file);
  file.simulate = false;  // a real cell, as far as the run knows
  order_.cell = file;
  const auto& arm = file.cell().arm;
  const Joints before = JointReader(arm).read().q;
  expect_plan(record_run(order_, catalogue_));
  EXPECT_EQ(JointReader(arm).read().q, before);
  // Each program that the host sends writes its number before anything else, and the heartbeat is an input
  // register.
  RtdeClient rtde(
      {arm.address, arm.rtde_port},
      [](const UrVersion&) {
        return RtdeRecipe{
            {"output_int_register_24", "input_int_register_24", "payload", "robot_status_bits"}, {}, {}};
      },
      arm.rtde);
  const RtdeSample sample = rtde.sample();
  EXPECT_EQ(sample.get<std::int32_t>("output_int_register_24"), 0);
  EXPECT_EQ(sample.get<std::int32_t>("input_int_register_24"), 0);
  EXPECT_NEAR(sample.get<double>("payload"), 2.5 + 0.65 + 0.20, 0.5) << "the installation's";
  ThreeFingerGripper gripper(file.cell().gripper);
  EXPECT_FALSE(gripper.is_active()) << "a command would have activated it";
}

// Where no script port, gripper or force sensor listens a dry run works as well: it does not ask them.
TEST_F(DryRun, ConnectsArmAndCameraAlone) {
  CellFile file = read_cell(data_path("cells/loopback-ur10.yaml"));
  file.serve({true, false, false, true});
  const ServedCell served(*this, file);
  file.simulate = false;
  auto& cell = file.cell();
  cell.arm.primary_port = cell.arm.secondary_port = cell.arm.realtime_port = cell.arm.dashboard_port = 1;
  cell.gripper.modbus.port = cell.force_torque.port = 1;
  order_.cell = file;
  expect_plan(record_run(order_, catalogue_));
}

/// Largest speed of the tool in what a dry run planned.
double fastest(const RecordedRun& done) {
  double speed = 0.0;
  for (const PlannedStep& step : done.report.result.planned) speed = std::max(speed, step.tool_speed);
  return speed;
}

TEST_F(DryRun, ARealCellIsSlowUntilItHasCompletedARun) {
  CellFile file = read_cell(data_path("cells/loopback-ur10.yaml"));
  const ServedCell served(*this, file);
  file.simulate = false;
  order_.cell = file;
  const std::string out = order_.out, state = out + "_state";
  ::setenv("XDG_STATE_HOME", state.c_str(), 1);
  const auto run = [&](const char* name) {
    order_.out = out + name;
    const RecordedRun done = record_run(order_, catalogue_);
    std::filesystem::remove_all(order_.out);
    return fastest(done);
  };
  EXPECT_LE(run("_new"), 1.001 * kSlowToolSpeed);
  EXPECT_FALSE(is_known_cell(file.path)) << "a dry run completes nothing";
  order_.speed = RunSpeed::kFull;
  EXPECT_GT(run("_asked"), 1.1 * kSlowToolSpeed);
  order_.speed = RunSpeed::kByDefault;
  note_known_cell(file.path);
  EXPECT_GT(run("_known"), 1.1 * kSlowToolSpeed);
  ::unsetenv("XDG_STATE_HOME");
  std::filesystem::remove_all(state);
}

TEST_F(DryRun, ReportsThatTheCameraSeesNoStone) {
  order_.run.simulation.seed = 3;
  SimulatedCell world(catalogue_.stones, {}, order_.robot, CellLayout{}, order_.run.simulation);
  Cell cell = world.cell();
  const FirstStep first = plan_first_step(cell, catalogue_, order_.robot, order_.run.build);
  EXPECT_EQ(first.result.end, RunEnd::kNothingSeen);
  EXPECT_THAT(first.result.ended, HasSubstr("jog it so that the camera"));
  EXPECT_TRUE(first.result.planned.empty());
}

TEST(ReadOnlyDevices, RefuseEveryCommand) {
  RobotModel robot = read_robot("ur10");
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  SimulatedCell world(catalogue.stones, {}, robot, CellLayout{}, {});
  Cell inner = world.cell();
  ReadOnlyDevices devices([&] { return inner.arm.state(); }, inner.camera, inner.clock, inner.layout);
  Cell cell = devices.cell();
  EXPECT_EQ(cell.arm.state().q, inner.arm.state().q);
  EXPECT_THROW((void)cell.arm.follow({}), InvalidArgument);
  EXPECT_THROW((void)cell.arm.follow_guarded({}), InvalidArgument);
  EXPECT_THROW(cell.arm.set_payload(1.0, Eigen::Vector3d::Zero()), InvalidArgument);
  EXPECT_THROW(cell.gripper.move(0.0, 0.1, 10.0), InvalidArgument);
  EXPECT_THROW(cell.gripper.spread(0.05), InvalidArgument);
  EXPECT_THROW(cell.force_torque.zero(), InvalidArgument);
  cell.arm.stop();
}

}  // namespace
}  // namespace stonestack::report
