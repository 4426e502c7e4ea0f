#pragma once
#include <array>

#include "emulators/camera/camera_simulator.hpp"
#include "emulators/robotiq/ft_simulator.hpp"
#include "emulators/robotiq/gripper_simulator.hpp"
#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/cell_config.hpp"
#include "stonestack/emulators/simulated_servers.hpp"

namespace stonestack::emulators {

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

}  // namespace stonestack::emulators
