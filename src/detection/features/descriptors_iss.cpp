#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "detection/features/descriptors.hpp"
#include "detection/scene/point_grid.hpp"

namespace stonestack::detection {
namespace {

constexpr int kShells = 5;           // radial bins
constexpr std::size_t kFewest = 10;  // neighbours

/// 66 directions: the corners of an octahedron whose edges are split in four.
const std::vector<Eigen::Vector3f>& directions() {
  static const std::vector<Eigen::Vector3f> all = [] {
    std::vector<Eigen::Vector3f> made;
    for (int x = -4; x <= 4; ++x)
      for (int y = std::abs(x) - 4; y <= 4 - std::abs(x); ++y) {
        const int z = 4 - std::abs(x) - std::abs(y);
        made.push_back(Eigen::Vector3i(x, y, z).cast<float>().normalized());
        if (z != 0) made.push_back(Eigen::Vector3i(x, y, -z).cast<float>().normalized());
      }
    return made;
  }();
  return all;
}

/// Principal axes of the neighbourhood, most spread first. The last one points where the surface does, the
/// first one to the side that holds more of the neighbourhood: two of Zhong's four frames fall away with the
/// normal, one more with the count.
Eigen::Matrix3f intrinsic_frame(const std::vector<Eigen::Vector3f>& offsets, const Eigen::Vector3f& normal) {
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (const auto& d : offsets) scatter += d * d.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(scatter);
  Eigen::Vector3f z = solver.eigenvectors().col(0), x = solver.eigenvectors().col(2);
  if (z.dot(normal) < 0) z = -z;
  float side = 0;
  for (const auto& d : offsets) side += x.dot(d) * std::abs(x.dot(d));
  if (side < 0) x = -x;
  Eigen::Matrix3f frame;
  frame << x, z.cross(x), z;
  return frame;
}

/// How the neighbourhood fills cells of direction and distance, the latter shared between two shells.
Eigen::RowVectorXf signature(const std::vector<Eigen::Vector3f>& offsets, const Eigen::Matrix3f& frame,
                             float radius) {
  const auto& cells = directions();
  Eigen::RowVectorXf row = Eigen::RowVectorXf::Zero(static_cast<Eigen::Index>(cells.size()) * kShells);
  for (const auto& d : offsets) {
    const Eigen::Vector3f q = frame.transpose() * d;
    std::size_t cell = 0;
    float best = -2.0F * radius;
    for (std::size_t k = 0; k < cells.size(); ++k)
      if (const float along = cells[k].dot(q); along > best) best = along, cell = k;
    const float at = std::clamp(q.norm() / radius * kShells - 0.5F, 0.0F, kShells - 1.0F);
    const int shell = std::min(static_cast<int>(at), kShells - 2);
    const float part = at - static_cast<float>(shell);
    row(static_cast<Eigen::Index>(cell) * kShells + shell) += 1.0F - part;
    row(static_cast<Eigen::Index>(cell) * kShells + shell + 1) += part;
  }
  return row.normalized();
}

}  // namespace

Features iss_features(const SurfacePoints& surface, std::span<const int> keypoints, double radius) {
  const auto width = static_cast<Eigen::Index>(directions().size()) * kShells;
  Eigen::MatrixXf rows(static_cast<Eigen::Index>(keypoints.size()), width);
  const PointGrid grid(surface.points, static_cast<float>(radius));
  tbb::parallel_for(std::size_t{0}, keypoints.size(), [&](std::size_t k) {
    const auto i = static_cast<std::size_t>(keypoints[k]);
    std::vector<Eigen::Vector3f> offsets;
    grid.for_each_near(surface.points[i], static_cast<float>(radius), [&](int j, float d2) {
      if (d2 > 0) offsets.emplace_back(surface.points[static_cast<std::size_t>(j)] - surface.points[i]);
    });
    auto row = rows.row(static_cast<Eigen::Index>(k));
    if (offsets.size() < kFewest)
      row.setConstant(std::nanf(""));
    else
      row = signature(offsets, intrinsic_frame(offsets, surface.normals[i]), static_cast<float>(radius));
  });
  return finite_features(surface, keypoints, rows);
}

}  // namespace stonestack::detection
