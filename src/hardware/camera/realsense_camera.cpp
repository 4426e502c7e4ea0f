#include "hardware/camera/realsense_camera.hpp"

#include "hardware/camera/realsense_device.hpp"

namespace stonestack::hardware {

FieldList fields(RealsenseCameraOptions& o) {
  FieldList own = {
      user(field("serial", o.serial, "of the camera; empty: the first one that is found")),
      field("width", o.width, {1, 4096}, "pixel", "one of the camera's formats"),
      field("height", o.height, {1, 4096}, "pixel", "one of the camera's formats"),
      field("rate", o.rate, {1, 300}, "1/s", "one of the camera's rates"),
      field("frame_timeout", o.frame_timeout, {0.05, 60.0}, "s", "until the next frame"),
  };
  return join({own, fields(o.check)});
}

RealsenseCamera::RealsenseCamera(const RealsenseCameraOptions& options) : device_(open_realsense(options)) {}

DepthFrame RealsenseCamera::capture() {
  return device_->capture();
}

}  // namespace stonestack::hardware
