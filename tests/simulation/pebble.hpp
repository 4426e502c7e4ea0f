#pragma once
#include <algorithm>
#include <cmath>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack::simulation {

/// A rounded stone with gentle bumps and cut flat above and below, axes 1.3 : 1 : 0.7, of the given mass.
inline Stone make_pebble(const std::string& name, double mass) {
  constexpr double kDensity = 2600.0;
  Mesh mesh = make_sphere(1.0, 3);
  for (auto& p : mesh.vertices) {
    const double bump =
        1.0 + 0.04 * std::sin(4 * p.x() + 1) * std::cos(5 * p.y()) + 0.03 * std::sin(6 * p.z());
    p = bump * p.cwiseProduct(Eigen::Vector3d(1.3, 1.0, 0.95));
    p.z() = std::clamp(p.z(), -0.7, 0.7);
  }
  const double scale = std::cbrt(mass / (kDensity * volume(mesh)));
  Stone stone;
  stone.name = name;
  stone.scan = scaled(mesh, scale);
  const Eigen::Vector3d centre = mass_properties(stone.scan, kDensity).p_O_M;
  stone.scan = transformed(stone.scan, make_pose(Eigen::Vector3d(-centre)));
  stone.mesh = stone.scan;
  stone.mass = mass_properties(stone.scan, kDensity);
  return stone;
}

/// Fingers down, closing along world x turned by `yaw`, tips at p_W.
inline Pose tool_down(const Eigen::Vector3d& p_W, double yaw = 0.0) {
  constexpr double kPi = 3.14159265358979323846;
  Pose T_W_T = Pose::Identity();
  T_W_T.linear() =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  T_W_T.translation() = p_W;
  return T_W_T;
}

}  // namespace stonestack::simulation
