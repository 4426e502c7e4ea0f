#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "stonestack/emulators/camera/camera_simulator.hpp"
#include "stonestack/emulators/robotiq/ft_simulator.hpp"
#include "stonestack/emulators/robotiq/gripper_simulator.hpp"
#include "stonestack/emulators/ur/ur_controller_server.hpp"
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
/// `layout` with the camera where the simulated one sits: what a simulated world is made of.
/// @throws InvalidArgument for a quaternion that is not one.
[[nodiscard]] CellLayout true_layout(CellLayout layout, const SimulatedServersOptions& options);
/// arm.*, gripper.*, force_torque.*, camera.*, and the faults below each.
[[nodiscard]] FieldList fields(SimulatedServersOptions& options);

/// One simulated world behind all its protocols, from construction to destruction: UR controller, gripper,
/// force sensor, camera. Time passes as the wall clock's, times `arm.speed`.
class SimulatedServers {
 public:
  /// `cell` must outlive it, and nobody else may touch its world meanwhile.
  /// @throws DeviceError when a port is taken.
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

}  // namespace stonestack::emulators

#pragma GCC visibility pop
