#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "emulators/camera/camera_simulator.hpp"
#include "emulators/robotiq/ft_simulator.hpp"
#include "emulators/robotiq/gripper_simulator.hpp"
#include "emulators/ur/ur_controller_server.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

#pragma GCC visibility push(default)

namespace stonestack::emulators {

/// Which devices are served; the world behind them is whole.
struct ServedDevices {
  bool arm = true, gripper = true, force_torque = true, camera = true;
};

/// The simulated devices of a cell behind their real protocols.
struct SimulatedServersOptions {
  UrServerOptions arm;
  GripperSimulatorOptions gripper;
  FtSimulatorOptions force_torque;
  CameraSimulatorOptions camera;
  GripperFaults gripper_faults;
  ModbusFaults modbus_faults;
  FtFaults force_torque_faults;
  CameraFaults camera_faults;
  ServedDevices devices;
  /// Where the camera really sits in the tool, whatever a cell file says of it: x, y, z (m), qx, qy, qz, qw.
  std::array<double, 7> T_T_C;

  SimulatedServersOptions();  ///< force sensor as a TCP stream, no pseudo terminals, standard camera mount
};
/// `layout` with the camera where the simulated one sits: what a simulated world is made of. Throws
/// InvalidArgument for a quaternion that is not one.
[[nodiscard]] CellLayout true_layout(CellLayout layout, const SimulatedServersOptions& options);
/// arm.*, gripper.*, force_torque.*, camera.*, and the faults below each.
[[nodiscard]] FieldList fields(SimulatedServersOptions& options);

/// One simulated world behind all its protocols, from construction to destruction: UR controller, gripper,
/// force sensor, camera. Time passes as the wall clock's, times `arm.speed`.
class SimulatedServers {
 public:
  /// `cell` must outlive it, and nobody else may touch its world meanwhile. Throws DeviceError when a port is
  /// taken.
  SimulatedServers(SimulatedCell& cell, const RobotModel& robot, const SimulatedServersOptions& options);
  ~SimulatedServers();

  /// All 0 when no arm is served.
  [[nodiscard]] UrPorts arm_ports() const;
  [[nodiscard]] std::string arm_address() const;
  /// Where each listens; empty when it does not serve TCP.
  [[nodiscard]] std::optional<Endpoint> gripper() const;
  [[nodiscard]] std::optional<Endpoint> force_torque() const;
  [[nodiscard]] std::optional<Endpoint> camera() const;
  /// Paths of the pseudo terminals; empty when it does not serve a serial line.
  [[nodiscard]] std::string gripper_line() const;
  [[nodiscard]] std::string force_torque_line() const;
  /// A line a device: where it can be reached.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] const SimulatedServersOptions& options() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Content of a cell file: the devices, and, if `simulate`, how this program serves them itself.
struct CellFile {
  std::string path;
  bool simulate = false;
  CellConfig cell;
  SimulatedServersOptions servers;
};
/// `simulate` and the group `simulators`; CellConfig has the rest.
[[nodiscard]] FieldList cell_fields(CellFile& file);
/// Reads a cell file by its path, or by the name of a cell that comes with stonestack, "loopback-ur10".
/// @throws FileError
[[nodiscard]] CellFile read_cell(const std::string& name);
/// True if another process serves the standard ports of a simulated cell.
/// @throws Interrupted
[[nodiscard]] bool is_served_elsewhere(const CellFile& file);

/// Writes the addresses and ports where the servers listen into the client side of a cell.
void connect_to(const SimulatedServers& servers, CellConfig& cell);

}  // namespace stonestack::emulators

#pragma GCC visibility pop
