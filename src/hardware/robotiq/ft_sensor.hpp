#pragma once
#include <memory>
#include <string>

#include "stonestack/core/options.hpp"
#include "stonestack/hardware/devices.hpp"

namespace stonestack::hardware {

/// Robotiq's FT150 and FT300: a stream of 100 readings a second, either on a serial line or from the UR cap's
/// TCP server on the robot's controller.
///
/// Link `ur` is the arm's own sensor (UrForceTorque); it has only `stale`, the ranges and `stuck_samples`.
struct FtSensorOptions {
  std::string link = "serial";        ///< serial, ur_cap or ur
  std::string device;                 ///< serial: path of the line
  int unit = 9;                       ///< serial
  std::string address = "127.0.0.1";  ///< ur_cap: the robot's controller
  int port = 63351;                   ///< ur_cap
  double start_timeout = 3.0;         ///< time [s] until the first reading
  double listen = 0.16;               ///< time [s] that a serial line is listened to before it is spoken to
  double stale = 0.05;                ///< an older reading is an error [s]
  double max_force = 150.0;           ///< force [N] on an axis: FT150; 300 for the FT300, by the arm for `ur`
  double max_torque = 15.0;           ///< torque [Nm] on an axis: FT150; 30 for the FT300
  int stuck_samples = 100;            ///< equal readings running that mean a dead sensor; 0: never
  double yaw = 0.0;                   ///< angle [rad] about z, from the flange's axes to the sensor's
};
[[nodiscard]] FieldList fields(FtSensorOptions& options);

/// How the stream does; counted since the start.
struct FtStreamHealth {
  long readings = 0;
  long skipped = 0;    ///< readings that nobody asked for in time
  long bad_bytes = 0;  ///< bytes dropped while looking for a frame
  long restarts = 0;   ///< times the stream was started anew
  double rate = 0.0;   ///< readings/s, over the last second or so
};

/// A thread of its own always drains the stream and keeps the newest reading only. Zeroing happens here, in
/// the host: the sensor's own zero is never touched. `device_time` is the host's steady time of arrival.
class RobotiqFtSensor final : public ForceTorqueSensor {
 public:
  /// Opens the link and starts the stream. A sensor that streams already is taken as it is; one that is
  /// silent or garbles is silenced, asked who it is, and started.
  /// @throws DeviceError with the link and the last bytes when no reading comes in `start_timeout`.
  explicit RobotiqFtSensor(const FtSensorOptions& options);
  ~RobotiqFtSensor() override;

  /// A reading that was not returned before; waits for it up to `stale`.
  /// @throws DeviceError when none comes (the stream is started anew meanwhile), when one axis exceeds its
  /// range and when the reading is stuck.
  [[nodiscard]] Wrench read() override;
  /// Mean of the next `kZeroSamples` readings.
  /// @throws DeviceError when they spread too far.
  void zero() override;
  [[nodiscard]] FtStreamHealth health() const;
  /// Firmware as the sensor reported it when it was started here; empty when it streamed already or over the
  /// cap.
  [[nodiscard]] std::string firmware() const;

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace stonestack::hardware
