#pragma once
#include <string>

#include "hardware/robotiq/ft_sensor.hpp"
#include "hardware/ur/rtde_client.hpp"
#include "hardware/ur/ur_arm.hpp"

namespace stonestack::hardware {

/// `force_torque.link` of a cell whose arm has a force sensor of its own.
inline constexpr const char* kOwnSensorLink = "ur";

/// Recipe that reads the arm's own force sensor at the controller at `address`. It throws DeviceError for a
/// controller without a usable reading: a CB-series arm (PolyScope 3), PolyScope before 5.9, PolyScope X.
[[nodiscard]] RtdeRecipeFor own_sensor_recipe(const std::string& address);

/// Force sensor in the flange of an e-Series arm, over an RTDE connection of its own at 100 Hz, the rate of a
/// Robotiq sensor.
///
/// It reads `ft_raw_wrench` (PolyScope 5.9): force and torque at the flange in its axes, N and Nm, as the
/// world acts on it, with the weight of all that hangs there. Set payloads, started programs and
/// zero_ftsensor() leave it alone. It has a large constant part (users report 25 kN along z), so
/// readings are relative to the first one until `zero` is called. `device_time` is the controller's clock.
///
/// Not `actual_TCP_force`: that one loses the weight of the payload and becomes zero whenever a payload is
/// set, which every program of this driver does, so the weight of a stone is not in it. Not tried on
/// hardware.
class UrForceTorque final : public ForceTorqueSensor {
 public:
  /// Connects and takes the first reading. Of `sensor` it uses `stale`, `max_force`, `max_torque` and
  /// `stuck_samples`.
  /// @throws DeviceError: see RtdeClient and own_sensor_recipe.
  UrForceTorque(const UrArmOptions& arm, const FtSensorOptions& sensor);

  /// A reading that was not returned before; waits for it up to `stale`.
  /// @throws DeviceError when none comes, when an axis is beyond its range and when the reading is stuck.
  [[nodiscard]] Wrench read() override;
  /// Takes the mean of the next readings as zero, in the host.
  /// @throws DeviceError when they spread too far.
  void zero() override;
  /// The controller's.
  [[nodiscard]] UrVersion version() const { return rtde_.version(); }

 private:
  [[nodiscard]] RtdeSample next_sample();

  FtSensorOptions options_;
  std::string name_;
  RtdeClient rtde_;
  double last_time_ = -1.0;  // s, the controller's clock
  Wrench last_;              // as it came
  int equal_ = 0;            // readings running that are the same
  Wrench zero_;
};

}  // namespace stonestack::hardware
