#pragma once
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::hardware {

/// One frame; `number` and `device_time` rise from frame to frame, a repeated one is a DeviceError.
struct DepthFrame {
  DepthImage image;
  long number = 0;
  double device_time = 0.0;  ///< s
  double host_time = 0.0;    ///< s of `host_seconds`, when it was here; in a simulated cell of its clock
};

class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  /// A frame exposed after the call.
  [[nodiscard]] virtual DepthFrame capture() = 0;
};

}  // namespace stonestack::hardware
