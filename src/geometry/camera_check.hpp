#pragma once
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::geometry {

/// Throws InvalidArgument unless a camera has pixels (at most 16384 a side) and finite, positive focal
/// lengths.
inline void require_usable(const CameraIntrinsics& camera) {
  require(camera.width >= 1 && camera.width <= 16384 && camera.height >= 1 && camera.height <= 16384,
          "a camera has 1 to 16384 pixels a side, got ", camera.width, " x ", camera.height);
  require(camera.fx > 0.0 && camera.fy > 0.0 && std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
              std::isfinite(camera.cx) && std::isfinite(camera.cy),
          "a camera needs positive focal lengths and a finite centre, got fx ", camera.fx, ", fy ", camera.fy,
          ", cx ", camera.cx, ", cy ", camera.cy);
}

/// Requires a usable camera and a depth for each pixel.
inline void require_usable(const DepthImage& image) {
  require_usable(image.camera);
  const auto pixels =
      static_cast<std::size_t>(image.camera.width) * static_cast<std::size_t>(image.camera.height);
  require(image.z.size() == pixels, "a depth image of ", image.camera.width, " x ", image.camera.height,
          " needs ", pixels, " depths, got ", image.z.size());
}

inline std::size_t pixel_index(const CameraIntrinsics& camera, int u, int v) {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u);
}

inline DepthImage make_empty_image(const CameraIntrinsics& camera) {
  require_usable(camera);
  return {camera, std::vector<float>(pixel_index(camera, 0, camera.height), 0.0F)};
}

}  // namespace stonestack::geometry
