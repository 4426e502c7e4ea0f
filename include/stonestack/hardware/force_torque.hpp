#pragma once
#include <Eigen/Core>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// Force (N) and torque (Nm) at the sensor, axes of the flange F, what the world does to the tool.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  double device_time = 0.0;  ///< [s]
  double host_time = 0.0;    ///< s of `host_seconds`, when it arrived; in a simulated cell of its clock
};

/// A wrist sensor. A reading older than 50 ms is a DeviceError.
class ForceTorqueSensor {
 public:
  virtual ~ForceTorqueSensor() = default;
  /// Latest reading, minus the zero.
  [[nodiscard]] virtual Wrench read() = 0;
  /// Takes the mean of the next readings at rest as zero.
  virtual void zero() = 0;
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop
