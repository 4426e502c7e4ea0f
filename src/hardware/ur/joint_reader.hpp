#pragma once
#include "hardware/ur/ur_arm.hpp"

namespace stonestack::hardware {

/// Joint angles as a controller reported them.
struct JointReading {
  Joints q = Joints::Zero();  ///< [rad]
  double device_time = 0.0;   ///< clock of the controller [s]
};

/// Reads where a UR arm is, beside whatever drives it: claims no register and sends nothing, so that it works
/// in local mode, too.
class JointReader {
 public:
  /// @throws DeviceError: see RtdeClient.
  explicit JointReader(const UrArmOptions& options);
  /// A reading received after the call, or else the newest.
  /// @throws DeviceError if that is stale
  [[nodiscard]] JointReading read() const;

 private:
  RtdeClient rtde_;
};

}  // namespace stonestack::hardware
