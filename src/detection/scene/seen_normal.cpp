#include "detection/scene/seen_normal.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::detection {
namespace {

constexpr int kNarrowest = 4;      // px to each side
constexpr int kWidest = 16;        // px: nearer than 7 cm for any sensor
constexpr double kReach = 0.006;   // m to each side
constexpr double kMaxStep = 0.02;  // m between the pixels: more is an edge

}  // namespace

int normal_span(const CameraIntrinsics& camera, double z) {
  return std::clamp(static_cast<int>(kReach * camera.fx / std::max(z, 0.01)), kNarrowest, kWidest);
}

Eigen::Vector3d seen_normal(const DepthImage& depth, int u, int v) {
  const double z = depth.at(u, v);
  const int span = normal_span(depth.camera, z);
  if (u < span || v < span || u + span >= depth.camera.width || v + span >= depth.camera.height)
    return Eigen::Vector3d::Zero();
  const auto point = [&](int du, int dv) -> Eigen::Vector3d {
    const double at = depth.at(u + du, v + dv);
    return std::abs(at - z) < kMaxStep ? Eigen::Vector3d(at * deproject(depth.camera, u + du, v + dv))
                                       : Eigen::Vector3d::Constant(std::nan(""));
  };
  const Eigen::Vector3d across = point(span, 0) - point(-span, 0);
  const Eigen::Vector3d down = point(0, span) - point(0, -span);
  const Eigen::Vector3d normal = down.cross(across);  // towards the camera: x right, y down, z forward
  return normal.allFinite() && normal.norm() > 1e-12 ? Eigen::Vector3d(normal.normalized())
                                                     : Eigen::Vector3d::Zero();
}

}  // namespace stonestack::detection
