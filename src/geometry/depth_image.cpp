#include "stonestack/geometry/depth_image.hpp"

#include <cmath>
#include <limits>

#include "geometry/camera_check.hpp"

namespace stonestack::geometry {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// The Brown-Conrady polynomial on the plane z = 1, and its derivative.
struct Distorted {
  Vector2d p;
  Matrix2d slope;
};

Distorted distorted(const double (&k)[5], const Vector2d& p) {
  const double x = p.x();
  const double y = p.y();
  const double r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double radial_slope = 2.0 * (k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4]));  // of x: x times this
  const Vector2d tangential(2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
                            2.0 * k[3] * x * y + k[2] * (r2 + 2.0 * y * y));
  const double mixed = x * y * radial_slope + 2.0 * (k[2] * x + k[3] * y);
  Matrix2d slope;
  slope << radial + x * x * radial_slope + 2.0 * k[2] * y + 6.0 * k[3] * x, mixed,  //
      mixed, radial + y * y * radial_slope + 2.0 * k[3] * x + 6.0 * k[2] * y;
  return {radial * p + tangential, slope};
}

/// Newton's method; where the polynomial folds over, the nearest point reached before the fold.
Vector2d undistorted(const double (&k)[5], const Vector2d& target) {
  Vector2d p = target;
  for (int i = 0; i < 30; ++i) {
    const Distorted at = distorted(k, p);
    if (at.slope.determinant() < 1e-6) break;
    const Vector2d step = at.slope.inverse() * (target - at.p);
    p += step;
    if (step.squaredNorm() < 1e-28) break;
  }
  return p;
}

}  // namespace

Eigen::Vector3d deproject(const CameraIntrinsics& camera, double u, double v) {
  Vector2d p((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
  switch (camera.distortion) {
    case CameraIntrinsics::Distortion::kNone:
      break;
    case CameraIntrinsics::Distortion::kBrownConrady:
      p = undistorted(camera.k, p);
      break;
    case CameraIntrinsics::Distortion::kInverseBrownConrady:
      p = distorted(camera.k, p).p;
      break;
  }
  return {p.x(), p.y(), 1.0};
}

Eigen::Vector2d project(const CameraIntrinsics& camera, const Eigen::Vector3d& p_C) {
  require(p_C.z() > 0.0, "only a point in front of the camera has a pixel, got z = ", p_C.z(), " m");
  Vector2d p = p_C.head<2>() / p_C.z();
  switch (camera.distortion) {
    case CameraIntrinsics::Distortion::kNone:
      break;
    case CameraIntrinsics::Distortion::kBrownConrady:
      p = distorted(camera.k, p).p;
      break;
    case CameraIntrinsics::Distortion::kInverseBrownConrady:
      p = undistorted(camera.k, p);
      break;
  }
  return {camera.fx * p.x() + camera.cx, camera.fy * p.y() + camera.cy};
}

Cloud to_cloud(const DepthImage& image) {
  require_usable(image);
  const CameraIntrinsics& camera = image.camera;
  Cloud cloud;
  cloud.width = camera.width;
  cloud.height = camera.height;
  cloud.points.assign(image.z.size(), Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const float z = image.at(u, v);
      if (!(z > 0.0F) || !std::isfinite(z)) continue;
      cloud.points[pixel_index(camera, u, v)] =
          (static_cast<double>(z) * deproject(camera, u, v)).cast<float>();
    }
  }
  return cloud;
}

DepthImage to_depth_image(const Cloud& cloud_C, const CameraIntrinsics& camera) {
  DepthImage image = make_empty_image(camera);
  for (const Eigen::Vector3f& point : cloud_C.points) {
    if (!point.allFinite() || point.z() <= 0.0F) continue;
    const Vector2d pixel = (project(camera, point.cast<double>()).array() + 0.5).floor();
    if (!((pixel.array() >= 0.0).all() && pixel.x() < camera.width && pixel.y() < camera.height)) continue;
    float& z = image.z[pixel_index(camera, static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))];
    if (z == 0.0F || point.z() < z) z = point.z();
  }
  return image;
}

}  // namespace stonestack::geometry
