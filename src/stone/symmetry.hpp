#pragma once
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::stone {

/// An axis about which a shape may be turned without looking different, in O.
struct SymmetryAxis {
  Eigen::Vector3d n_O = Eigen::Vector3d::UnitZ();  ///< unit
  int order = 0;                                   ///< turns by 360 deg / order; 0: by any angle
  double deviation = 0.0;  ///< of the turned surface from the surface, 90 % quantile [m]
};

/// A plane in which a shape is its own mirror image, in O.
struct SymmetryPlane {
  Eigen::Vector3d n_O = Eigen::Vector3d::UnitZ();  ///< unit normal
  double deviation = 0.0;  ///< of the mirrored surface from the surface, 90 % quantile [m]
};

/// Symmetries of a shape. All axes and planes run through one point, the centroid of the surface.
struct Symmetries {
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  std::vector<SymmetryAxis> axes;  ///< those of any angle first; of the twofold ones across such an axis one
  std::vector<SymmetryPlane> planes;  ///< of those that hold or cross an axis of any angle one each
};

/// Finds the symmetries of a closed mesh that hold within 1.5 % of the diagonal of its bounding box, several
/// times what 500 faces take from a curved surface. Candidates are the principal
/// axes of the surface, directions across or between axes that are nearly as long, and large faces with their
/// sums and cross products; each is turned to where the surface lies nearest to itself (pattern search, Hooke
/// and Jeeves 1961).
[[nodiscard]] Symmetries find_symmetries(const Mesh& mesh);

/// The turns that the axes stand for and those that these combine to, but for those of any angle and without
/// the identity; at most 60.
[[nodiscard]] std::vector<Pose> discrete_turns(const Symmetries& symmetries);

}  // namespace stonestack::stone
