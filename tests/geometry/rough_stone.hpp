#pragma once
#include <cmath>

#include "stonestack/core/random.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// A closed polyhedron like a quarried stone, about 18 x 13 x 9 cm: flat cuts with sharp edges, a dent, and
/// roughness. For tests of this room.
inline Mesh make_rough_stone(std::uint64_t seed, int subdivisions = 3) {
  Random random = Random::stream(seed, "rough stone");
  Mesh mesh = make_sphere(1.0, subdivisions);
  std::vector<Eigen::Vector4d> cuts;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d n = random.unit_vector();
    cuts.emplace_back(n.x(), n.y(), n.z(), random.uniform(0.6, 0.9));
  }
  const Eigen::Vector3d dent = random.unit_vector();
  for (Eigen::Vector3d& v : mesh.vertices) {
    double radius = 1.0 - 0.25 * std::exp(-(v - dent).squaredNorm() / 0.1) + random.uniform(-0.01, 0.01);
    for (const Eigen::Vector4d& cut : cuts) {
      const double along = v.dot(cut.head<3>());
      if (along * radius > cut[3]) radius = cut[3] / along;
    }
    v = (radius * v).cwiseProduct(Eigen::Vector3d(0.09, 0.065, 0.045));
  }
  return mesh;
}

}  // namespace stonestack::geometry
