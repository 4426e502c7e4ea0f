#include <algorithm>
#include <cmath>

#include "geometry/mesh_edges.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {
namespace {

constexpr double kMaxSamples = 50e6;

/// Throws InvalidArgument when a lattice on every face would exceed kMaxSamples.
void require_few_samples(const Mesh& mesh, double spacing) {
  double count = static_cast<double>(mesh.vertices.size());
  for (const Eigen::Vector3i& face : mesh.faces) {
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) box.extend(mesh.vertices[static_cast<std::size_t>(face[k])]);
    const double parts = box.diagonal().norm() / spacing;
    count += 0.5 * parts * parts;
  }
  require(count < kMaxSamples, "a spacing of ", spacing, " m needs about ", count, " samples, more than ",
          kMaxSamples, "; take a wider one");
}

/// Where the samples of one edge's inside lie in the result, and how many parts the edge has.
struct SplitEdge {
  std::size_t first = 0;
  int parts = 1;
};

std::vector<SplitEdge> sample_edges(const Mesh& mesh, const MeshEdges& edges, double spacing,
                                    std::vector<SurfaceSample>& samples) {
  std::vector<SplitEdge> splits;
  splits.reserve(edges.edges.size());
  for (const MeshEdge& edge : edges.edges) {
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(edge.a)];
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(edge.b)];
    const double parts = std::max(1.0, std::ceil((b - a).norm() / spacing));
    splits.push_back({samples.size(), static_cast<int>(parts)});
    for (int i = 1; i < static_cast<int>(parts); ++i)
      samples.push_back({a + (i / parts) * (b - a), edge.normal});
  }
  return splits;
}

/// Spreads `area` over the inside points of an edge; an undivided edge gives it to its ends.
void share_edge_area(const MeshEdge& edge, const SplitEdge& split, double area,
                     std::vector<SurfaceSample>& samples) {
  if (split.parts == 1) {
    samples[static_cast<std::size_t>(edge.a)].area += 0.5 * area;
    samples[static_cast<std::size_t>(edge.b)].area += 0.5 * area;
    return;
  }
  for (int i = 1; i < split.parts; ++i)
    samples[split.first + static_cast<std::size_t>(i - 1)].area += area / (split.parts - 1);
}

}  // namespace

// A face is covered by a barycentric lattice with n parts a side, n from its longest edge. A lattice point
// stands for a third of each of its lattice triangles: 2 of them inside, 1 on an edge, 1/3 at a corner.
std::vector<SurfaceSample> sample_surface(const Mesh& mesh, double spacing) {
  require(spacing > 0.0, "samples need a positive spacing, got ", spacing, " m");
  require_few_samples(mesh, spacing);
  const MeshEdges edges = make_mesh_edges(mesh);
  const std::vector<Eigen::Vector3d> face_normal = face_normals(mesh);
  const std::vector<Eigen::Vector3d> vertex_normal = vertex_normals(mesh);
  std::vector<SurfaceSample> samples;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    samples.push_back({mesh.vertices[v], vertex_normal[v]});
  const std::vector<SplitEdge> splits = sample_edges(mesh, edges, spacing, samples);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh.faces[f];
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector3d ab = mesh.vertices[static_cast<std::size_t>(face[1])] - a;
    const Eigen::Vector3d ac = mesh.vertices[static_cast<std::size_t>(face[2])] - a;
    int n = 1;
    for (const int e : edges.of_face[f]) n = std::max(n, splits[static_cast<std::size_t>(e)].parts);
    const double lattice_area = 0.5 * ab.cross(ac).norm() / n / n;
    for (int k = 0; k < 3; ++k) {
      const auto e = static_cast<std::size_t>(edges.of_face[f][static_cast<std::size_t>(k)]);
      share_edge_area(edges.edges[e], splits[e], (n - 1) * lattice_area, samples);
      samples[static_cast<std::size_t>(face[k])].area += lattice_area / 3.0;
    }
    for (int i = 1; i < n; ++i)
      for (int j = 1; i + j < n; ++j)
        samples.push_back({a + (i * ab + j * ac) / n, face_normal[f], 2.0 * lattice_area});
  }
  return samples;
}

}  // namespace stonestack::geometry
