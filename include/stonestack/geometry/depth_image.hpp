#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/cloud.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Pinhole camera with lens distortion; optical frame C.
struct CameraIntrinsics {
  /// Model of the lens distortion: none, Brown-Conrady, or its inverse.
  enum class Distortion { kNone, kBrownConrady, kInverseBrownConrady };
  int width = 640;                            ///< columns [px]
  int height = 480;                           ///< rows [px]
  double fx = 475.0;                          ///< pixels; SR300: 68 x 54 deg at 640 x 480
  double fy = 475.0;                          ///< focal length along v [px]
  double cx = 319.5;                          ///< principal point along u [px]
  double cy = 239.5;                          ///< principal point along v [px]
  Distortion distortion = Distortion::kNone;  ///< model that the coefficients belong to
  double k[5] = {0, 0, 0, 0, 0};              ///< k1 k2 p1 p2 k3
};

/// Depth along the optical axis, row by row; 0 where there is none. Metres.
struct DepthImage {
  CameraIntrinsics camera;  ///< intrinsics of the camera
  std::vector<float> z;     ///< depths [m], row by row; 0 where there is none
  /// Depth [m] at column `u` and row `v`; 0 where there is none.
  [[nodiscard]] float at(int u, int v) const { return z[static_cast<std::size_t>(v * camera.width + u)]; }
};

/// A depth image as a camera took it; `number` and `device_time` rise from frame to frame, a repeated one is
/// a DeviceError.
struct DepthFrame {
  DepthImage image;          ///< frame of the recording
  long number = 0;           ///< number of the frame in the recording
  double device_time = 0.0;  ///< [s]
  double host_time = 0.0;  ///< time by `host_seconds` [s], when it was here; in a simulated cell of its clock
};

/// Ray through a pixel centre with z = 1, lens distortion removed.
[[nodiscard]] Eigen::Vector3d deproject(const CameraIntrinsics& camera, double u, double v);
/// Pixel of a point with z > 0, lens distortion applied.
[[nodiscard]] Eigen::Vector2d project(const CameraIntrinsics& camera, const Eigen::Vector3d& p_C);
/// Organised cloud in C; NaN where there is no depth.
[[nodiscard]] Cloud to_cloud(const DepthImage& image);
/// Renders a cloud in C (organised or not) into a depth image: nearest point wins.
[[nodiscard]] DepthImage to_depth_image(const Cloud& cloud_C, const CameraIntrinsics& camera);
/// 16-bit greyscale PNG, `unit` metres a count (SR300: 0.000125).
/// @throws FileError
void write_depth_png(const std::string& path, const DepthImage& image, double unit);
[[nodiscard]] DepthImage read_depth_png(const std::string& path, const CameraIntrinsics& camera, double unit);

/// Pinhole intrinsics that explain an organised cloud in C (least squares of u on x/z and of v on y/z).
/// @return empty for a cloud that is not organised, has fewer than 100 points, or does not fit a pinhole
/// within a pixel (median).
[[nodiscard]] std::optional<CameraIntrinsics> fit_camera(const Cloud& organised_C);

/// A pinhole camera for a cloud in C without rows: wide enough for all but a hundredth of the points (up to
/// 56 deg off the axis), its pixels far enough apart for the points to fill them: 475 px of focal length, or
/// as much less, down to a sixth, as a thinned cloud needs.
[[nodiscard]] CameraIntrinsics camera_for(const Cloud& cloud_C);

/// True for an organised cloud of which one image axis, but not both, runs against x or y: it shows things as
/// a mirror would.
[[nodiscard]] bool is_mirrored(const Cloud& organised_C);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
