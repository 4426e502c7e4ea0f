#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::physics {

/// A face that may touch: its plane and, for each side, the inward normal in the plane.
struct FaceFeature {
  Eigen::Vector3d n;        ///< outward, unit
  double offset = 0.0;      ///< n . p = offset
  Eigen::Vector3d side[3];  ///< unit, pointing into the face
  double side_offset[3] = {0, 0, 0};
};

/// A convex edge with the directions that lead from it into its two faces: its normal cone is
/// {n : n . d = 0, n . into0 <= 0, n . into1 <= 0}.
struct EdgeFeature {
  Eigen::Vector3d p0, p1, d;  ///< ends, unit direction
  Eigen::Vector3d into0, into1, n_mean;
  double length = 0.0;
};

/// A point from which contact candidates are looked up: a vertex, or a point on a convex edge.
struct FeatureSample {
  Eigen::Vector3d p;
  int vertex = -1;
  int edge = -1;
};

/// A ball around consecutive samples (or consecutive balls).
struct SampleBall {
  Eigen::Vector3d centre;
  double radius = 0.0;
  int begin = 0, end = 0;
};

/// The vertices, convex edges and faces of a closed mesh, arranged for exact contact: two polyhedra first
/// touch vertex on face or edge on edge, so these pairs are all that contact between concave stones needs.
/// Frame O.
struct SurfaceFeatures {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<int> fan_begin;        ///< vertex v has fan[fan_begin[v] .. fan_begin[v + 1])
  std::vector<Eigen::Vector3d> fan;  ///< unit directions from a vertex to its neighbours
  std::vector<FaceFeature> faces;
  std::vector<EdgeFeature> edges;
  std::vector<FeatureSample> samples;  ///< grouped by ball
  std::vector<SampleBall> balls;       ///< over samples, about 7 mm wide
  std::vector<SampleBall> groups;      ///< over balls, about 28 mm wide
  Eigen::AlignedBox3d box;

  /// Features within `kLookup` of a point, by the grid cell it lies in; empty spans outside.
  struct Cell {
    const int* face_begin = nullptr;
    const int* face_end = nullptr;
    const int* edge_begin = nullptr;
    const int* edge_end = nullptr;
  };
  [[nodiscard]] Cell near(const Eigen::Vector3d& p) const;

  // The grid behind `near`.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  double cell = 0.005;
  std::vector<int> face_start, face_list, edge_start, edge_list;
};

/// A feature nearer than this to a point is found by `near` of that point [m].
inline constexpr double kLookup = 0.0046;
/// Spacing of samples on an edge [m].
inline constexpr double kEdgeSpacing = 0.003;

/// Throws InvalidArgument if the mesh is not closed.
[[nodiscard]] SurfaceFeatures surface_features(const Mesh& mesh);

}  // namespace stonestack::physics
