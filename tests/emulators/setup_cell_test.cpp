// A new cell file against the simulated controller.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/cell_config.hpp"
#include "script_bench.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SetUpCell : public testing::Test {
 protected:
  SetUpCell() { std::filesystem::create_directories(folder_); }
  ~SetUpCell() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] ControllerDescription described(const std::string& robot, const std::string& version,
                                                double payload, const std::string& safety = "57F4285B") {
    UrServerOptions options;
    options.safety_checksum = safety;
    options.version = version;
    options.payload = payload;
    options.payload_cog = {0.0, 0.01, 0.1};
    options.speed = 4.0;
    UrControllerServer server(options, read_robot(robot), plant_);
    server.start();
    CellConfig config;
    config.arm.address = "127.0.0.1";
    config.arm.rtde.stale_after = 1.0;
    const UrPorts ports = server.ports();
    config.arm.rtde_port = ports.rtde;
    config.arm.primary_port = ports.primary;
    config.arm.secondary_port = ports.secondary;
    config.arm.dashboard_port = ports.dashboard;
    return describe_controller(config);
  }
  [[nodiscard]] CellSetup order(const std::string& name) const {
    CellSetup setup;
    setup.path = folder_ + "/" + name;
    setup.arm = "192.168.1.10";
    setup.gripper_address = "192.168.1.11";
    return setup;
  }
  [[nodiscard]] static std::string problem(const std::function<void()>& act) {
    try {
      act();
    } catch (const Error& error) {
      return concat(static_cast<int>(error.exit_code()), ' ', error.what());
    }
    return "";
  }

  std::string folder_ = test::temporary_folder() + "set_up_cell_" +
                        testing::UnitTest::GetInstance()->current_test_info()->name();
  IdealPlant plant_{ScriptBench::start()};
};

TEST_F(SetUpCell, TheCellOfACb3IsAsItsControllerSays) {
  const ControllerDescription controller = described("ur10", "3.15.8.106339", 3.3);
  EXPECT_EQ(controller.model, "UR10");
  EXPECT_FALSE(controller.e_series);
  ASSERT_TRUE(controller.payload && controller.p_F_payload && controller.dh);
  EXPECT_EQ(*controller.payload, 3.3);
  EXPECT_EQ(controller.p_F_payload->z(), 0.1);
  EXPECT_NEAR((*controller.dh)[1][2], -0.612, 1e-4) << "length of the upper arm, UR's data sheet";
  const NewCell made = write_new_cell(order("lab.yaml"), controller);
  EXPECT_EQ(made.robot, "ur10");
  EXPECT_EQ(made.robot_file, "") << "no calibration";
  EXPECT_THAT(made.notes, IsEmpty());
  const CellConfig cell = read_cell_file(made.path);
  EXPECT_EQ(cell.robot, "ur10");
  EXPECT_EQ(cell.arm.address, "192.168.1.10");
  EXPECT_EQ(cell.gripper.modbus.address, "192.168.1.11");
  EXPECT_FALSE(cell.has_own_sensor());
  EXPECT_EQ(cell.sensor_mass, 0.65);
  EXPECT_EQ(cell.limits.tool_speed, 0.25);
}

TEST_F(SetUpCell, AnESeriesArmHasItsOwnSensorAndAHandBehindItsUrcap) {
  const ControllerDescription controller = described("ur10e", "5.11.1.108318", 0.2);
  EXPECT_TRUE(controller.e_series);
  CellSetup setup = order("lab.yaml");
  setup.gripper = "robotiq-2f-85";
  setup.gripper_address.clear();
  const NewCell made = write_new_cell(setup, controller);
  EXPECT_EQ(made.robot, "ur10e");
  ASSERT_FALSE(made.notes.empty());
  EXPECT_THAT(made.notes.front(), HasSubstr("0.2 kg")) << "gripper and camera weigh more";
  const CellConfig cell = read_cell_file(made.path);
  EXPECT_TRUE(cell.has_own_sensor());
  EXPECT_EQ(cell.gripper_driver, "robotiq_2f");
  EXPECT_EQ(cell.sensor_mass, 0.0);
}

TEST_F(SetUpCell, TheSafetyConfigurationIsNoted) {
  const ControllerDescription controller = described("ur10", "3.15.8.106339", 3.3);
  const NewCell made = write_new_cell(order("lab.yaml"), controller);
  EXPECT_EQ(read_cell_file(made.path).arm.safety_checksum, "57F4285B");
  EXPECT_THAT(new_cell_json(made, controller), HasSubstr("\"safety_checksum\": \"57F4285B\""));
  const ControllerDescription silent = described("ur10", "3.15.8.106339", 3.3, "");
  const NewCell without = write_new_cell(order("other.yaml"), silent);
  EXPECT_EQ(read_cell_file(without.path).arm.safety_checksum, "");
  EXPECT_THAT(without.notes, testing::Contains(HasSubstr("no checksum of its safety configuration")));
  EXPECT_THAT(new_cell_json(without, silent), testing::Not(HasSubstr("safety_checksum")));
}

TEST_F(SetUpCell, TheArmIsKnownByItsSerialNumber) {
  const ControllerDescription controller = described("ur10", "3.15.8.106339", 3.3);
  EXPECT_EQ(controller.serial, UrServerOptions().serial);
  const NewCell made = write_new_cell(order("lab.yaml"), controller);
  EXPECT_EQ(read_cell_file(made.path).arm.serial, controller.serial);
  EXPECT_THAT(new_cell_json(made, controller), HasSubstr("\"serial\": \"" + controller.serial + "\""));
  const ControllerDescription silent = described("ur10", "3.10.0.1", 3.3);
  EXPECT_EQ(silent.serial, "") << "before PolyScope 3.12";
  ControllerDescription odd = controller;
  odd.serial = "1\"\nrobot: ur3";
  EXPECT_EQ(read_cell_file(write_new_cell(order("odd.yaml"), odd).path).arm.serial, "");
}

TEST_F(SetUpCell, AnotherArmAtTheAddressIsNotConnectedTo) {
  UrServerOptions options;
  options.serial = "2014301234";
  UrControllerServer server(options, read_robot("ur10"), plant_);
  server.start();
  const auto problem_with = [&](const std::string& serial) {
    CellConfig config;
    config.arm.address = "127.0.0.1";
    config.arm.dashboard_port = server.ports().dashboard;
    config.arm.rtde_port = 1;  // nothing listens there
    config.arm.rtde.attempts = 1;
    config.force_torque.link = "serial";
    config.force_torque.device = "/dev/nothing";
    config.arm.serial = serial;
    return problem([&] { const HardwareCell cell(config); });
  };
  EXPECT_THAT(problem_with("2099999999"),
              testing::AllOf(HasSubstr("serial number 2014301234"), HasSubstr("arm.serial is 2099999999")));
  EXPECT_THAT(problem_with("2014301234"), testing::Not(HasSubstr("arm.serial"))) << "the next device fails";
}

TEST_F(SetUpCell, ACalibratedArmGetsARobotFileBesideTheCell) {
  ControllerDescription controller = described("ur10", "3.15.8.106339", 3.3);
  (*controller.dh)[1][2] -= 0.0012;  // upper arm
  (*controller.dh)[2][0] += 0.0008;  // elbow's zero
  const NewCell made = write_new_cell(order("lab.yaml"), controller);
  EXPECT_EQ(made.robot_file, folder_ + "/lab-robot.yaml");
  EXPECT_GT(made.calibration, 0.001);
  EXPECT_LT(made.calibration, 0.003);
  const RobotModel robot = read_cell_robot(read_cell_file(made.path));
  const Joints stretched = Joints::Zero();
  const double longer = std::abs(forward(robot, stretched).translation().x()) -
                        std::abs(forward(read_robot("ur10"), stretched).translation().x());
  EXPECT_NEAR(longer, 0.0012 - 0.0008 * 0.1157, 2e-6)
      << "the wrist hangs d5 = 0.1157 m below the elbow's axis";
}

TEST_F(SetUpCell, NothingIsWrittenOverOrForAnArmThatIsUnknown) {
  ControllerDescription controller = described("ur10", "3.15.8.106339", 3.3);
  static_cast<void>(write_new_cell(order("lab.yaml"), controller));
  const std::string before = read_file(folder_ + "/lab.yaml", 1 << 16);
  EXPECT_THAT(problem([&] { static_cast<void>(write_new_cell(order("lab.yaml"), controller)); }),
              HasSubstr("--force"));
  EXPECT_EQ(read_file(folder_ + "/lab.yaml", 1 << 16), before);
  write_file(folder_ + "/other-robot.yaml", "robot: ur10\n");  // somebody's own
  EXPECT_THAT(problem([&] { static_cast<void>(write_new_cell(order("other.yaml"), controller)); }),
              HasSubstr("other-robot.yaml"));
  std::filesystem::remove(folder_ + "/other-robot.yaml");
  CellSetup odd = order("other.yaml");
  odd.gripper_address = "1: {";
  EXPECT_THAT(problem([&] { static_cast<void>(write_new_cell(odd, controller)); }), HasSubstr("2 '1: {'"));
  odd = order("other.yaml");
  odd.arm.clear();
  EXPECT_THAT(problem([&] { static_cast<void>(write_new_cell(odd, controller)); }),
              HasSubstr("2 the robot's address is missing"));
  controller.model = "UR99";
  EXPECT_THAT(problem([&] { static_cast<void>(write_new_cell(order("other.yaml"), controller)); }),
              HasSubstr("ur99"));
  (*controller.dh)[1][2] = -2.0;  // another robot's
  controller.model = "UR10";
  EXPECT_NE(problem([&] { static_cast<void>(write_new_cell(order("other.yaml"), controller)); }), "");
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    files.push_back(entry.path().filename());
  EXPECT_THAT(files, testing::ElementsAre("lab.yaml"));
}

}  // namespace
}  // namespace stonestack::emulators
