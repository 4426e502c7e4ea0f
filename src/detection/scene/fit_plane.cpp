#include "detection/scene/fit_plane.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace stonestack::detection {

std::optional<Plane> plane_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                   const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double area = normal.norm();
  if (area < 1e-4) return {};
  Plane plane{normal / area, 0.0};
  plane.offset = plane.normal.dot(a);
  if (plane.offset > 0) plane = {-plane.normal, -plane.offset};
  return plane;
}

Plane fit_plane(std::span<const Eigen::Vector3d> points, Plane plane, double tolerance) {
  for (int turn = 0; turn < 2; ++turn) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
    int count = 0;
    for (const auto& p : points)
      if (std::abs(plane.distance(p)) < tolerance) sum += p, outer += p * p.transpose(), ++count;
    if (count < 3) return plane;
    const Eigen::Vector3d mean = sum / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(outer / count - mean * mean.transpose());
    Eigen::Vector3d normal = solver.eigenvectors().col(0);
    if (normal.dot(mean) > 0) normal = -normal;
    plane = {normal, normal.dot(mean)};
  }
  return plane;
}

}  // namespace stonestack::detection
