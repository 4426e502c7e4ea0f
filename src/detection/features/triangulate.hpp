#pragma once
#include <vector>

#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// Points with triangles over them: what rotational projection statistics describe.
struct TriangulatedSurface {
  SurfacePoints surface;
  std::vector<Eigen::Vector3i> triangles;
};

/// Surface that one view shows above the table, in C, on every n-th pixel so that points are about `spacing`
/// apart; neighbouring pixels are linked unless depth jumps between them.
[[nodiscard]] TriangulatedSurface triangulate(const DetectionScene& scene, int view, double spacing,
                                              double height_low, double height_high);

/// The mesh with every edge longer than `spacing` split, again and again.
[[nodiscard]] TriangulatedSurface subdivide(const Mesh& mesh, double spacing);

}  // namespace stonestack::detection
