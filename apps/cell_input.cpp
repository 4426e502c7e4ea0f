#include "cell_input.hpp"

#include <filesystem>

#include "stonestack/core/data.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::apps {

CellFile read_cell(const std::string& name) {
  const std::string shipped = data_path("cells/" + name + ".yaml");
  const bool known = !std::filesystem::exists(name) && std::filesystem::exists(shipped);
  CellFile file;
  const std::string& path = file.path = known ? shipped : name;
  file.cell = read_cell_file(path, join({{field("simulate", file.simulate, "serve the devices here")},
                                         nest("simulators", fields(file.servers))}));
  return file;
}

void connect_to(const SimulatedServers& servers, CellConfig& cell) {
  const UrPorts& ports = servers.arm_ports();
  cell.arm.address = servers.arm_address();
  cell.arm.rtde_port = ports.rtde;
  cell.arm.primary_port = ports.primary;
  cell.arm.secondary_port = ports.secondary;
  cell.arm.realtime_port = ports.realtime;
  cell.arm.dashboard_port = ports.dashboard;
  cell.gripper.modbus.address = servers.gripper().address;
  cell.gripper.modbus.port = servers.gripper().port;
  cell.force_torque.link = "ur_cap";
  cell.force_torque.address = servers.force_torque().address;
  cell.force_torque.port = servers.force_torque().port;
  cell.camera = "stream";
  cell.stream.address = servers.camera().address;
  cell.stream.port = servers.camera().port;
}

}  // namespace stonestack::apps
