// In builds without librealsense.
#include "hardware/camera/realsense_device.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {

std::unique_ptr<DepthCamera> open_realsense(const RealsenseCameraOptions&) {
  throw DeviceError("RealSense camera", "this build of stonestack has no librealsense",
                    "use camera.driver: v4l2, or build with librealsense 2 and -DSTONESTACK_REALSENSE=ON");
}

}  // namespace stonestack::hardware
