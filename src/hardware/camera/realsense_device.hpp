#pragma once
#include "hardware/camera/realsense_camera.hpp"

namespace stonestack::hardware {

/// The camera itself. Two files define it, of which a build takes one: with librealsense, and without.
[[nodiscard]] std::unique_ptr<DepthCamera> open_realsense(const RealsenseCameraOptions& options);

}  // namespace stonestack::hardware
