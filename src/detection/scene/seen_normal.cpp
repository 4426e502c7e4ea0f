#include "detection/scene/seen_normal.hpp"

#include <cmath>

namespace stonestack::detection {
namespace {

constexpr int kNormalSpan = 4;     // px to each side
constexpr double kMaxStep = 0.02;  // m between the pixels: more is an edge

}  // namespace

Eigen::Vector3d seen_normal(const DepthImage& depth, int u, int v) {
  if (u < kNormalSpan || v < kNormalSpan || u + kNormalSpan >= depth.camera.width ||
      v + kNormalSpan >= depth.camera.height)
    return Eigen::Vector3d::Zero();
  const double z = depth.at(u, v);
  const auto point = [&](int du, int dv) -> Eigen::Vector3d {
    const double at = depth.at(u + du, v + dv);
    return std::abs(at - z) < kMaxStep ? Eigen::Vector3d(at * deproject(depth.camera, u + du, v + dv))
                                       : Eigen::Vector3d::Constant(std::nan(""));
  };
  const Eigen::Vector3d across = point(kNormalSpan, 0) - point(-kNormalSpan, 0);
  const Eigen::Vector3d down = point(0, kNormalSpan) - point(0, -kNormalSpan);
  const Eigen::Vector3d normal = down.cross(across);  // towards the camera: x right, y down, z forward
  return normal.allFinite() && normal.norm() > 1e-12 ? Eigen::Vector3d(normal.normalized())
                                                     : Eigen::Vector3d::Zero();
}

}  // namespace stonestack::detection
