#pragma once
#include "modelling/distance_volume.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::modelling {

/// The closed surface where the distance is zero, with triangles in circles of at most `facet` m (Delaunay
/// refinement; Boissonnat and Oudot 2005); an empty mesh for a volume with nothing inside.
[[nodiscard]] Mesh surface_of(const DistanceVolume& volume, double facet);

}  // namespace stonestack::modelling
