#pragma once
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

/// Contact between closed meshes, computed from their triangles alone: what OdeWorld touches with. It shares
/// no code with the contact of World (physics/touch.hpp), so that each engine checks the other.
namespace stonestack::physics {

/// An edge whose faces meet at less than 180 deg.
struct ConvexEdge {
  Eigen::Vector3d p, d;  ///< begin [m], unit direction
  double length = 0.0;   ///< [m]
  std::array<int, 2> faces{-1, -1};
  std::array<Eigen::Vector3d, 2> into;  ///< unit, in each face, square to the edge and away from it
};

/// A mesh arranged for contact, in the frame of its vertices.
struct ContactMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
  std::vector<Eigen::Vector3d> normals;           ///< of the faces, unit, outward; zero without an area
  std::vector<ConvexEdge> edges;                  ///< convex ones
  std::vector<std::array<int, 3>> edges_of_face;  ///< -1: not convex
  std::vector<std::vector<int>> neighbours;       ///< of the vertices, along edges
  double radius = 0.0;                            ///< of the vertices about the origin [m]
};
/// The mesh must be closed.
[[nodiscard]] ContactMesh make_contact_mesh(const Mesh& mesh);

/// A point where two bodies touch.
struct MeshTouch {
  std::array<int, 3> features{};  ///< kind, feature of A, feature of B: names the touch from step to step
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  ///< unit, from B to A
  double gap = 0.0;                             ///< negative: depth [m]
};

/// Touches of two meshes: vertices that lead in the direction of a face, and convex edges that cross. Keeps
/// the pairs of features that may touch soon until the meshes have moved. Make one for a pair of bodies.
class MeshPair {
 public:
  /// Touches with a gap of at most `max_gap` (m); frame W. Bodies that go on moving as between the last two
  /// calls do not pass through each other between them.
  [[nodiscard]] std::vector<MeshTouch> touches(const ContactMesh& A, const ContactMesh& B, const Pose& T_W_A,
                                               const Pose& T_W_B, double max_gap);

 private:
  struct Pair {
    int a, b;
    auto operator<=>(const Pair&) const = default;
  };
  void refresh(const ContactMesh& A, const ContactMesh& B, const Pose& T_B_A, double reach);

  bool fresh_ = false;
  Pose T_listed_ = Pose::Identity();  ///< T_B_A of the lists
  Pose T_last_ = Pose::Identity();    ///< T_B_A of the last call
  double listed_depth_ = 0.0, deepest_ = 0.0;
  std::vector<Pair> vertices_of_a_, vertices_of_b_;  ///< vertex, face of the other
  std::vector<Pair> edges_;
};

/// Touches of a mesh with the plane n . p = offset below it: its vertices with a gap of at most `max_gap`
/// (m).
[[nodiscard]] std::vector<MeshTouch> plane_touches(const ContactMesh& mesh, const Pose& T_W_A,
                                                   const Eigen::Vector3d& n_W, double offset, double max_gap);

}  // namespace stonestack::physics
