#include <algorithm>
#include <filesystem>

#include "core/socket.hpp"
#include "emulators/servers_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kAnswer = 1.0;  // s in which a port that is served takes a connection

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

void connect_arm(const SimulatedServers& servers, CellConfig& cell) {
  if (!servers.options().devices.arm) return;
  const UrPorts ports = servers.arm_ports();
  cell.arm.address = servers.arm_address();
  const auto set = [](int& port, int open) {
    if (open > 0) port = open;  // one that a fault has closed stays where the cell file looks for it
  };
  set(cell.arm.rtde_port, ports.rtde);
  set(cell.arm.primary_port, ports.primary);
  set(cell.arm.secondary_port, ports.secondary);
  set(cell.arm.realtime_port, ports.realtime);
  set(cell.arm.dashboard_port, ports.dashboard);
}

void connect_two_fingers(const SimulatedServers& servers, CellConfig& cell) {
  const auto tcp = servers.gripper();
  const std::string line = servers.gripper_line();
  if (!line.empty() && (cell.gripper_link == "rtu" || !tcp)) {
    cell.gripper_link = "rtu";
    cell.gripper.modbus.device = line;
    cell.gripper.unit = servers.options().gripper.unit;
  } else if (tcp) {
    cell.gripper_link = "urcap";
    cell.gripper.modbus.address = tcp->address;
    cell.gripper.modbus.port = tcp->port;
  }
}

// The link that the cell file asks for where it is served, else the other one.
void connect_gripper(const SimulatedServers& servers, ThreeFingerOptions& gripper) {
  const auto tcp = servers.gripper();
  const std::string line = servers.gripper_line();
  const bool serial = gripper.preset == "rtu";
  if (!line.empty() && (serial || !tcp)) {
    gripper.modbus.device = line;
    if (serial) return;
    gripper.preset = "rtu";
    gripper.unit = servers.options().gripper.unit;
  } else if (tcp) {
    gripper.modbus.address = tcp->address;
    gripper.modbus.port = tcp->port;
    if (serial) gripper.preset = "tcp2018";
  }
}

void connect_force_torque(const SimulatedServers& servers, FtSensorOptions& sensor) {
  if (sensor.link == kOwnSensorLink) return;  // comes with the arm
  const auto tcp = servers.force_torque();
  const std::string line = servers.force_torque_line();
  const bool serial = sensor.link == "serial";
  if (!line.empty() && (serial || !tcp)) {
    sensor.device = line;
    if (serial) return;
    sensor.link = "serial";
    sensor.unit = servers.options().force_torque.unit;
  } else if (tcp) {
    sensor.link = "ur_cap";
    sensor.address = tcp->address;
    sensor.port = tcp->port;
  }
}

}  // namespace

struct CellFile::Content {
  CellConfig cell;
  SimulatedServersOptions servers;
};

CellFile::CellFile() : content_(std::make_unique<Content>()) {}
CellFile::~CellFile() = default;
CellFile::CellFile(const CellFile& other)
    : path(other.path), simulate(other.simulate), content_(std::make_unique<Content>(*other.content_)) {}
CellFile::CellFile(CellFile&& other) noexcept = default;
CellFile& CellFile::operator=(const CellFile& other) {
  return *this = CellFile(other);
}
CellFile& CellFile::operator=(CellFile&& other) noexcept = default;

CellConfig& CellFile::cell() {
  return content_->cell;
}
const CellConfig& CellFile::cell() const {
  return content_->cell;
}
SimulatedServersOptions& CellFile::servers() {
  return content_->servers;
}
const SimulatedServersOptions& CellFile::servers() const {
  return content_->servers;
}
const std::string& CellFile::robot() const {
  return content_->cell.robot;
}
const std::string& CellFile::arm_address() const {
  return content_->cell.arm.address;
}
void CellFile::serve(const ServedDevices& devices) {
  content_->servers.devices = devices;
}

FieldList cell_fields(CellFile& file) {
  return join({{user(field("simulate", file.simulate, "true: this program serves the devices itself"))},
               nest("simulators", fields(file.servers()))});
}

void set_cell(CellFile& file, const std::function<void(const FieldList&)>& set) {
  CellConfig& cell = file.cell();
  const PoseNumbers given = cell.T_T_C;
  const std::string gripper = cell.gripper_name;
  const bool own_sensor = cell.has_own_sensor();
  set(join({fields(cell), cell_fields(file)}));
  require(cell.gripper_name == gripper,
          "the gripper of a cell stands in its file, as tip, driver and stroke depend on it; write `hand: ",
          cell.gripper_name, "` there");
  require(
      cell.has_own_sensor() == own_sensor,
      "whether a sensor stands between flange and gripper is in the cell's file, as the tip depends on it; "
      "write `force_torque: {link: ",
      cell.force_torque.link, "}` there");
  require(cell.hand_eye.empty() || cell.T_T_C == given,
          "layout.T_T_C and layout.hand_eye are the same thing: set one of them, with --set layout.hand_eye= "
          "where the file names one");
  read_hand_eye(cell);
}

CellFile read_cell(const std::string& name) {
  CellFile file;
  const std::string& path = file.path = find_cell(name);
  file.cell() = read_cell_file(path, cell_fields(file));
  if (file.cell().has_own_sensor()) file.servers().devices.force_torque = false;
  return file;
}

bool is_served_elsewhere(const CellFile& file) {
  if (!file.servers().arm.standard_ports) return false;
  const auto answers = [&](int port) {
    try {
      (void)TcpStream::connect({file.servers().arm.address, port}, Deadline::in(kAnswer).or_interrupt());
      return true;
    } catch (const DeviceError&) {
      return false;
    }
  };
  const auto& arm = file.cell().arm;
  return answers(arm.dashboard_port) || answers(arm.primary_port) || answers(arm.rtde_port);
}

void connect_to(const SimulatedServers& servers, CellConfig& cell) {
  connect_arm(servers, cell);
  if (cell.gripper_driver == "robotiq_2f")
    connect_two_fingers(servers, cell);
  else
    connect_gripper(servers, cell.gripper);
  connect_force_torque(servers, cell.force_torque);
  const auto camera = servers.camera();
  if (!camera || cell.camera == "recorded") return;  // a recording needs nobody who serves it
  cell.camera = "stream";
  cell.stream.address = camera->address;
  cell.stream.port = camera->port;
}

}  // namespace stonestack::emulators
