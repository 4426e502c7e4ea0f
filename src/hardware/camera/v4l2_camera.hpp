#pragma once
#include <memory>
#include <string>

#include "hardware/camera/camera_settings.hpp"

namespace stonestack::hardware {

struct V4l2CameraOptions {
  std::string device = "/dev/video0";  ///< the depth node: an SR300 and a D4xx have several
  CameraSettings camera;               ///< V4L2 carries neither scale nor intrinsics
  double frame_timeout = 2.0;          ///< [s]
  std::string record;  ///< folder that keeps what the driver gives, as it came; empty: nothing is kept
  FrameCheckOptions check;
};
[[nodiscard]] FieldList fields(V4l2CameraOptions& options);

/// Depth cameras that the kernel's uvcvideo drives, in format Z16: SR300 (kernel 4.12 on), D4xx. Without
/// librealsense, which dropped the SR300 after 2.50.
class V4l2Camera final : public DepthCamera {
 public:
  /// Opens and starts streaming.
  /// @throws DeviceError when the node is missing, is no capture device or does not give Z16 of the size
  /// asked for; InvalidArgument when scale or focal lengths are not given; FileError when the folder to
  /// record to holds a recording already.
  explicit V4l2Camera(const V4l2CameraOptions& options);
  ~V4l2Camera() override;
  /// A frame whose time stamp lies after the call; frames that waited in the queue are dropped. `device_time`
  /// is the kernel's monotonic time, `number` the driver's sequence.
  /// @throws DeviceError when none comes in time, when the time stamps are of another clock, and what
  /// FrameCheck refuses.
  [[nodiscard]] DepthFrame capture() override;

 private:
  struct Device;
  std::unique_ptr<Device> device_;
};

}  // namespace stonestack::hardware
