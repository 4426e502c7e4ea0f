#pragma once
#include <memory>
#include <string>

#include "hardware/camera/camera_settings.hpp"

namespace stonestack::hardware {

struct RealsenseCameraOptions {
  std::string serial;  ///< of the camera; empty: the first one that is found
  int width = 640;
  int height = 480;
  int rate = 30;               ///< frames/s
  double frame_timeout = 2.0;  ///< [s]
  FrameCheckOptions check;
};
[[nodiscard]] FieldList fields(RealsenseCameraOptions& options);

/// A RealSense camera (D4xx, L515) through librealsense 2, which knows its intrinsics and depth unit where
/// V4L2 does not. Debian 12 has no package of it: the backend is built with -DSTONESTACK_REALSENSE=ON only,
/// and has been compiled against a declared part of that library's interface, never run on a camera.
/// SR300 and SR305 left librealsense after 2.50; use V4l2Camera for them.
class RealsenseCamera final : public DepthCamera {
 public:
  /// Starts the depth stream.
  /// @throws DeviceError: no such camera, no such format, or a build without the library.
  explicit RealsenseCamera(const RealsenseCameraOptions& options);
  /// A frame exposed from now on.
  /// @throws DeviceError at the deadline, and what FrameCheck refuses.
  [[nodiscard]] DepthFrame capture() override;

 private:
  std::unique_ptr<DepthCamera> device_;
};

}  // namespace stonestack::hardware
