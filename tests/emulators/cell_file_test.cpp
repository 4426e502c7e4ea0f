// Cell files with simulators, and the client side of a cell whose devices are served here.
#include <gmock/gmock.h>

#include "emulators/servers_options.hpp"
#include "simulation/pebble.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/emulators/simulated_servers.hpp"

namespace stonestack::emulators {
namespace {

using testing::HasSubstr;

/// Gripper, force sensor and camera of a small world on free ports.
struct Served {
  std::vector<Stone> stones{make_pebble("pebble", 1.2)};
  SimulatedCell world{stones, {0_stone}, read_robot("ur10"), {}, {}};
  SimulatedServers servers;

  explicit Served(const SimulatedServersOptions& options) : servers(world, read_robot("ur10"), options) {}

  static SimulatedServersOptions options(bool tcp, bool serial) {
    SimulatedServersOptions options;
    options.devices.arm = false;
    options.gripper.tcp = tcp;
    options.gripper.rtu = serial;
    options.gripper.port = options.force_torque.port = options.force_torque.command_port = 0;
    options.force_torque.cap = tcp;
    options.force_torque.serial = serial;
    return options;
  }
};

TEST(ServedCellFile, ACellIsFoundByPathOrName) {
  const CellFile shipped = read_cell("loopback-ur10");
  EXPECT_TRUE(shipped.simulate);
  EXPECT_EQ(read_cell(shipped.path).robot(), shipped.robot());
  EXPECT_FALSE(is_served_elsewhere(shipped)) << "its ports are free ones";
  try {
    (void)read_cell("loopback-ur11");
    FAIL() << "there is none";
  } catch (const FileError& problem) {
    EXPECT_THAT(problem.what(), HasSubstr("loopback-ur10"));
  }
}

TEST(ServedCellFile, TheClientTakesTheLinkThatIsServed) {
  const Served served(Served::options(true, false));
  CellConfig cell;
  cell.gripper.preset = "rtu";
  cell.force_torque.link = "serial";
  cell.camera = "v4l2";
  const UrArmOptions arm = cell.arm;
  connect_to(served.servers, cell);
  EXPECT_EQ(cell.gripper.preset, "tcp2018");
  EXPECT_EQ(cell.gripper.modbus.port, served.servers.gripper()->port);
  EXPECT_EQ(cell.force_torque.link, "ur_cap");
  EXPECT_EQ(cell.force_torque.port, served.servers.force_torque()->port);
  EXPECT_EQ(cell.camera, "stream");
  EXPECT_EQ(cell.stream.port, served.servers.camera()->port);
  EXPECT_EQ(cell.arm.address, arm.address) << "no arm is served";
  cell.camera = "recorded";
  connect_to(served.servers, cell);
  EXPECT_EQ(cell.camera, "recorded") << "a recording needs no server";
}

TEST(ServedCellFile, TheCellFileChoosesWhereBothLinksAreServed) {
  const Served served(Served::options(true, true));
  CellConfig serial;
  serial.gripper.preset = "rtu";
  serial.force_torque.link = "serial";
  connect_to(served.servers, serial);
  EXPECT_EQ(serial.gripper.preset, "rtu");
  EXPECT_EQ(serial.gripper.modbus.device, served.servers.gripper_line());
  EXPECT_EQ(serial.force_torque.link, "serial");
  EXPECT_EQ(serial.force_torque.device, served.servers.force_torque_line());
  CellConfig tcp;
  tcp.force_torque.link = "ur_cap";
  connect_to(served.servers, tcp);
  EXPECT_EQ(tcp.gripper.preset, "tcp2018");
  EXPECT_EQ(tcp.gripper.modbus.port, served.servers.gripper()->port);
  EXPECT_EQ(tcp.force_torque.link, "ur_cap");
}

TEST(ServedCellFile, TheClientTakesTheUnitsOfWhatIsServedOnSerialLines) {
  SimulatedServersOptions options = Served::options(false, true);
  options.gripper.unit = 7;
  options.force_torque.unit = 11;
  const Served served(options);
  CellConfig cell;
  cell.gripper.preset = "tcp2018";
  cell.force_torque.link = "ur_cap";
  connect_to(served.servers, cell);
  EXPECT_EQ(cell.gripper.unit, 7);
  const FtSensorOptions& sensor = cell.force_torque;
  EXPECT_EQ(sensor.unit, 11);
}

TEST(ServedCellFile, TheArmsOwnSensorIsServedByTheArm) {
  CellFile file = read_cell("loopback-ur10e");
  EXPECT_FALSE(file.servers().devices.force_torque);
  EXPECT_NEAR(to_layout(file.cell()).T_F_T.translation().z(), 0.223, 1e-12);
  const Served served(Served::options(true, true));
  connect_to(served.servers, file.cell());
  EXPECT_EQ(file.cell().force_torque.link, "ur") << "whatever else is served";
  const auto set_link = [](CellFile& cell, const char* value) {
    set_cell(cell, [&](const FieldList& list) { set_field(list, value); });
  };
  EXPECT_THROW(set_link(file, "force_torque.link=serial"), InvalidArgument) << "the tip depends on it";
  CellFile other = read_cell("loopback-ur10");
  EXPECT_NO_THROW(set_link(other, "force_torque.link=serial"));
  EXPECT_THROW(set_link(other, "force_torque.link=ur"), InvalidArgument);
}

TEST(ServedCellFile, SimulatorsAreSetByTheirNames) {
  SimulatedServersOptions options;
  FieldList list = nest("simulators", fields(options));
  set_field(list, "simulators.arm.model=UR5");
  EXPECT_EQ(options.arm.model, "UR5");
  set_field(list, "simulators.camera.unit=0.0005");
  EXPECT_DOUBLE_EQ(options.camera.unit, 0.0005);
}

}  // namespace
}  // namespace stonestack::emulators
