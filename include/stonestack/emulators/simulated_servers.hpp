#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {
struct Endpoint;  // private
}

namespace stonestack::emulators {

/// Which devices are served; the world behind them is whole.
struct ServedDevices {
  bool arm = true;           ///< controller of the arm
  bool gripper = true;       ///< gripper
  bool force_torque = true;  ///< force sensor
  bool camera = true;        ///< depth camera
};

/// Settings of the simulated devices of a cell behind their real protocols. Private: a program sets them by
/// their names, in the group `simulators` of a cell file or as `fields`.
struct SimulatedServersOptions;
struct UrPorts;  // private
/// `layout` with the camera where the simulated one sits: what a simulated world is made of. Throws
/// InvalidArgument for a quaternion that is not one.
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
  /// Address of the controller that is served, without ports.
  [[nodiscard]] std::string arm_address() const;
  /// Where each listens; empty when it does not serve TCP.
  [[nodiscard]] std::optional<Endpoint> gripper() const;
  /// Endpoint of the force sensor's server; empty if it is not served over TCP.
  [[nodiscard]] std::optional<Endpoint> force_torque() const;
  /// Endpoint of the camera's server; empty if it is not served.
  [[nodiscard]] std::optional<Endpoint> camera() const;
  /// Paths of the pseudo terminals; empty when it does not serve a serial line.
  [[nodiscard]] std::string gripper_line() const;
  /// Path of the serial line on which the force sensor is served; empty if there is none.
  [[nodiscard]] std::string force_torque_line() const;
  /// A line a device: where it can be reached.
  [[nodiscard]] std::string text() const;
  /// Options of the servers.
  [[nodiscard]] const SimulatedServersOptions& options() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Content of a cell file: the devices, and, if `simulate`, how this program serves them itself.
class CellFile {
 public:
  std::string path;       ///< path of the file; empty: none was read
  bool simulate = false;  ///< true: this program simulates and serves the devices itself

  CellFile();
  ~CellFile();
  /// Copies settings and options.
  CellFile(const CellFile& other);
  /// Takes over settings and options.
  CellFile(CellFile&& other) noexcept;
  /// Copies settings and options.
  CellFile& operator=(const CellFile& other);
  /// Takes over settings and options.
  CellFile& operator=(CellFile&& other) noexcept;
  /// Settings of the cell, to be changed.
  [[nodiscard]] CellConfig& cell();
  /// Settings of the cell.
  [[nodiscard]] const CellConfig& cell() const;
  /// Options of the simulated servers, to be changed.
  [[nodiscard]] SimulatedServersOptions& servers();
  /// Options of the simulated servers.
  [[nodiscard]] const SimulatedServersOptions& servers() const;
  /// Name of the cell's robot: ur3 to ur16e, or the path of a URDF.
  [[nodiscard]] const std::string& robot() const;
  /// Address of the cell's arm; empty: none.
  [[nodiscard]] const std::string& arm_address() const;
  /// Lets these devices be served, and no others.
  void serve(const ServedDevices& devices);

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};
/// `simulate` and the group `simulators`; CellConfig has the rest.
[[nodiscard]] FieldList cell_fields(CellFile& file);
/// Lets `set` change all fields of a cell, and reads anew what depends on them: the file of a hand-eye
/// calibration. Throws InvalidArgument when it sets layout.T_T_C beside such a file.
void set_cell(CellFile& file, const std::function<void(const FieldList&)>& set);
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
