#include "cell_input.hpp"

#include <algorithm>
#include <filesystem>

#include "stonestack/core/data.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::apps {

namespace {

/// The path itself, or that of a cell that comes with stonestack.
std::string find_cell(const std::string& name) {
  if (std::filesystem::exists(name)) return name;
  const std::filesystem::path folder = data_path("cells");
  const auto shipped = folder / (name + ".yaml");
  if (std::filesystem::exists(shipped)) return shipped;
  std::vector<std::string> known;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) known.push_back(entry.path().stem());
  std::sort(known.begin(), known.end());
  std::string list;
  for (const auto& cell : known) list += (list.empty() ? "" : ", ") + cell;
  throw FileError(name, "no such file, nor a cell of that name", "cells that come with stonestack: " + list);
}

}  // namespace

FieldList cell_fields(CellFile& file) {
  return join({{field("simulate", file.simulate, "serve the devices here")},
               nest("simulators", fields(file.servers))});
}

CellFile read_cell(const std::string& name) {
  CellFile file;
  const std::string& path = file.path = find_cell(name);
  file.cell = read_cell_file(path, cell_fields(file));
  return file;
}

void connect_to(const SimulatedServers& servers, CellConfig& cell) {
  const UrPorts& ports = servers.arm_ports();
  cell.arm.address = servers.arm_address();
  const auto set = [](int& port, int open) {
    if (open > 0) port = open;  // one that a fault has closed stays where the cell file looks for it
  };
  set(cell.arm.rtde_port, ports.rtde);
  set(cell.arm.primary_port, ports.primary);
  set(cell.arm.secondary_port, ports.secondary);
  set(cell.arm.realtime_port, ports.realtime);
  set(cell.arm.dashboard_port, ports.dashboard);
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
