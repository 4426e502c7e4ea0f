#pragma once
#include <memory>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// Signed distance to a closed mesh, negative inside, on a grid with trilinear interpolation, clamped to
/// +-`band`. Exact at the nodes; between them worst at sharp edges, which it rounds (measured within 1 mm of
/// 1000-face scans of rocks at a cell of 1.5 mm: median 5 um, worst 0.5 mm, a third of the cell). Nodes stand
/// only within the band. Immutable, shared between threads; copies share the grid.
class SignedDistance {
 public:
  /// `cell` in metres; throws InvalidArgument if the mesh is not closed or the grid would exceed 64 million
  /// nodes.
  SignedDistance(const Mesh& mesh, double cell, double band);

  /// `band` outside the grid [m].
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const;
  /// Distance and its unit gradient, outward near the surface: the direction of steepest rise of the
  /// interpolation. Zero where the distance is clamped, so flat.
  [[nodiscard]] double distance(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) const;
  [[nodiscard]] double band() const;
  [[nodiscard]] const Eigen::AlignedBox3d& box() const;

 private:
  struct Grid;
  std::shared_ptr<const Grid> grid_;
};

}  // namespace stonestack::geometry
