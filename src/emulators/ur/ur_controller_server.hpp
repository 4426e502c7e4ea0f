#pragma once
#include <memory>
#include <string>

#include "emulators/ur/plant.hpp"
#include "protocol/ur_version.hpp"
#include "stonestack/core/options.hpp"

namespace stonestack::emulators {

/// Faults of a controller, one switch each (numbers: docs/failure-modes.md).
/// Times are seconds since `start` on the controller's clock; a negative time means never.
struct ControllerFaults {
  bool fieldbus_owns_lower_registers = false;  ///< 1: input registers 0..23 answer IN_USE
  bool fieldbus_owns_outputs = false;          ///< 2: inputs that set digital and analogue outputs, likewise
  bool fieldbus_stops_programs = false;        ///< 3: protective stop as soon as a program starts
  std::string missing_fields;                  ///< 4: outputs, separated by commas, that answer NOT_FOUND
  double drop_rtde_at = -1.0;         ///< 6: sessions go dead: the link stays open and nothing comes any more
  double close_rtde_at = -1.0;        ///< 6, 9: every RTDE link is closed once
  double restart_rtde_at = -1.0;      ///< 7: as while booting: links closed, port refused for two seconds
  double boot_seconds = -1.0;         ///< 7: the controller's clock starts here instead of long ago
  bool refuse_protocol_2 = false;     ///< V(2) is answered with no
  bool message_before_reply = false;  ///< a text message precedes every setup reply (PolyScope X)
  bool out_of_step = false;           ///< 8: after ten data packages one with a wrong length
  bool split_packets = false;         ///< every byte in a segment of its own
  bool local_mode = false;            ///< 11: e-Series not in remote control: scripts refused with C210
  int read_only_links = 0;            ///< 11: so many script connections, the first ones, only read (C210)
  bool scripts_never_start = false;   ///< 12: a script is taken and nothing happens
  double script_dies_after = -1.0;    ///< 13: run-time exception that long after a program started
  double protective_stop_at = -1.0;   ///< 15
  double emergency_stop_at = -1.0;    ///< 16
  double speed_slider = 1.0;          ///< 17: 0 is "paused by user"
  bool no_dashboard = false;          ///< 21: no server on port 29999
  bool no_rtde = false;               ///< 22: port closed in the security settings
  bool no_script_ports = false;       ///< 22
  bool refuse_unlock = false;         ///< the protective stop cannot be acknowledged
};
[[nodiscard]] FieldList fields(ControllerFaults& faults);

struct UrServerOptions {
  std::string address = "127.0.0.1";      ///< any 127.x.y.z
  bool standard_ports = false;            ///< 30001 to 30004, 30011 to 30013, 29999; else free ones
  std::string version = "3.15.8.106339";  ///< PolyScope; 3.x: CB3 at 125 Hz, 5.x: e-Series at 500 Hz,
                                          ///< 10.x: PolyScope X, which has no Dashboard (failure mode 21)
  std::string model = "UR10";             ///< as the Dashboard names it
  std::string serial = "2014301234";
  /// Checksum of the safety configuration, eight hexadecimal digits; empty: states do not have it.
  std::string safety_checksum = "2F0B1D6A";
  double speed = 1.0;  ///< control steps a second, times the real ones
  /// Programs, separated by commas, that the Dashboard finds: `load hello.urp`. Played, one runs until it is
  /// stopped, and does nothing: what a program on the pendant does that waits for others.
  std::string programs;
  /// Port on 127.0.0.1 where the script sender of UR's client library is asked for the program when
  /// `external_control.urp` is played, as its URCap does; 0: the URCap is not installed.
  int external_control = 0;
  /// Payload of the installation on the pendant; SimulatedServers: the gripper that is
  /// there.
  double payload = 0.0;                                   ///< [kg]
  Eigen::Vector3d payload_cog = Eigen::Vector3d::Zero();  ///< from the flange [m]
  ControllerFaults faults;
};
[[nodiscard]] FieldList fields(UrServerOptions& options);
/// True for the versions of the e-Series, whose arms have a force sensor in the flange; false for a CB3.
/// @throws InvalidArgument for a version that it cannot be.
[[nodiscard]] bool has_own_sensor(const UrServerOptions& options);

/// The program on the pendant that consists of the URCap External Control.
inline constexpr const char* kExternalControl = "external_control.urp";

/// Ports in use; 0 where a fault closed one.
struct UrPorts {
  int primary = 0, secondary = 0, realtime = 0, rtde = 0;
  int primary_read_only = 0, secondary_read_only = 0, realtime_read_only = 0;
  int dashboard = 0;
};

/// A simulated UR controller behind its real protocols: RTDE, primary, secondary and realtime script ports,
/// their read-only twins, Dashboard. One thread does all: a control step moves the plant, programs run in
/// URScript's own time, sockets are served between steps.
class UrControllerServer {
 public:
  /// `plant` must outlive this and is used from the server's thread only, while it runs.
  /// @throws InvalidArgument for a version or address that it cannot be.
  UrControllerServer(const UrServerOptions& options, const RobotModel& robot, Plant& plant);
  ~UrControllerServer();

  /// Binds the ports and starts.
  /// @throws DeviceError when one is taken.
  void start();
  /// Closes every link and ends the thread.
  void stop();
  [[nodiscard]] const UrPorts& ports() const;

  /// Cuts every RTDE link now; as a pulled cable and a restart of the service do. Thread-safe.
  void cut_rtde();
  /// Puts the robot into a protective stop now. Thread-safe.
  void protective_stop(const std::string& reason);
  /// Changes the switches while it runs. Thread-safe.
  void set_faults(const ControllerFaults& faults);
  /// Seconds of simulated control time since `start`. Thread-safe.
  [[nodiscard]] double time() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::emulators
