#pragma once
#include <vector>

#include "stone/gradient_noise.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::stone {

/// The form of a piece of rubble before it gets its skin, as a radius over directions. Lengths are in units
/// of the half extents: a unit ball, warped by noise, cut by planes and hollowed by balls; `half` makes
/// metres.
struct Rubble {
  /// Half space {p : normal . p <= offset} that the stone lies in.
  struct Cut {
    Eigen::Vector3d normal;
    double offset;
  };
  /// A hollow: a ball of `radius` that eats `depth` deep into the surface in `direction`.
  struct Dent {
    Eigen::Vector3d direction;
    double radius;
    double depth;
  };

  Eigen::Vector3d half = Eigen::Vector3d::Ones();  ///< half of the extents [m]
  std::vector<Cut> cuts;
  std::vector<Dent> dents;
  double roughness = 0.0;  ///< RMS [m]
  std::uint64_t seed = 0;  ///< of its noise
};

/// Draws a form: two bedding planes and 4 to 10 cleavage planes, 4 to 8 chipped corners, 1 to 3 dents.
[[nodiscard]] Rubble draw_rubble(Random& random, const Eigen::Vector3d& extents);
/// The form on a unit sphere's vertices, with dents and hollows `concavity` times as deep as drawn; extents
/// are those of the rubble, to the roughness.
[[nodiscard]] Mesh surface(const Rubble& rubble, const Mesh& sphere, double concavity);

}  // namespace stonestack::stone
