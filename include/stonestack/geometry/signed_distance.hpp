#pragma once
#include <memory>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack {

/// Signed distance to a closed mesh, negative inside, on a grid with trilinear interpolation; exact to a
/// fraction of the cell near the surface, and clamped to +-`band` away from it. Immutable, shared between
/// threads.
class SignedDistance {
 public:
  /// `cell` in metres; throws InvalidArgument if the mesh is not closed or the grid would exceed 64 million
  /// nodes.
  SignedDistance(const Mesh& mesh, double cell, double band);
  ~SignedDistance();
  SignedDistance(SignedDistance&&) noexcept;
  SignedDistance& operator=(SignedDistance&&) noexcept;

  /// m; `band` outside the grid.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const;
  /// Distance and its unit gradient (outward near the surface).
  [[nodiscard]] double distance(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) const;
  [[nodiscard]] double band() const;
  [[nodiscard]] const Eigen::AlignedBox3d& box() const;

 private:
  struct Grid;
  std::unique_ptr<Grid> grid_;
};

}  // namespace stonestack
