#include "geometry/surface_tree.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "geometry/closest_on_triangle.hpp"
#include "geometry/mesh_edges.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

constexpr int kLeafSize = 4;

/// Inner node: children at `first` and `first + 1`. Leaf: `count` triangles from `first`.
struct Node {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  int first = 0;
  int count = 0;

  [[nodiscard]] double squared_distance(const Eigen::Vector3d& p) const {
    return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
  }
};

struct TreeTriangle {
  Eigen::Vector3d a, ab, ac;
  Eigen::Vector3d middle;  ///< of a ball around the triangle
  double radius;
  int face;
};

TreeTriangle make_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                           int face) {
  const Eigen::Vector3d middle = (a + b + c) / 3.0;
  const double radius = std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()});
  return {a, b - a, c - a, middle, radius, face};
}

struct Best {
  double squared;
  int triangle = -1;
  ClosestOnTriangle closest{};
};

/// Nodes yet to be looked at. The tree is balanced, so at most 32 deep for any int count of faces.
struct Waiting {
  int node;
  double squared;
};
using WaitingList = std::array<Waiting, 64>;

}  // namespace

struct SurfaceTree::Tree {
  std::vector<Node> nodes;
  std::vector<TreeTriangle> triangles;
  std::vector<int> triangle_of_face;  ///< -1: without area
  std::vector<Eigen::Vector3i> faces;
  std::vector<Eigen::Vector3d> face_normal, vertex_normal;
  MeshEdges edges;

  void split(std::size_t node, int first, int last);
  void try_triangle(int index, const Eigen::Vector3d& p, Best& best) const;
  void search(const Eigen::Vector3d& p, Best& best) const;
  [[nodiscard]] std::vector<int> triangles_within(const Eigen::Vector3d& p, double reach) const;
  [[nodiscard]] SurfacePoint surface_point(const Eigen::Vector3d& p, const Best& best) const;
  [[nodiscard]] Eigen::Vector3d pseudonormal(int face, TriangleFeature feature) const;
};

void SurfaceTree::Tree::split(std::size_t node, int first, int last) {
  Eigen::AlignedBox3d centres;
  for (int i = first; i < last; ++i) {
    const TreeTriangle& t = triangles[static_cast<std::size_t>(i)];
    centres.extend(t.middle);
    for (const Eigen::Vector3d& corner : {t.a, Eigen::Vector3d(t.a + t.ab), Eigen::Vector3d(t.a + t.ac)}) {
      nodes[node].low = nodes[node].low.cwiseMin(corner);
      nodes[node].high = nodes[node].high.cwiseMax(corner);
    }
  }
  if (last - first <= kLeafSize) {
    nodes[node].first = first;
    nodes[node].count = last - first;
    return;
  }
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  std::nth_element(triangles.begin() + first, triangles.begin() + middle, triangles.begin() + last,
                   [&](const TreeTriangle& s, const TreeTriangle& t) {
                     const double cs = s.middle[axis];
                     const double ct = t.middle[axis];
                     return cs < ct || (cs == ct && s.face < t.face);
                   });
  const std::size_t children = nodes.size();
  nodes[node].first = static_cast<int>(children);
  nodes.resize(children + 2);
  split(children, first, middle);
  split(children + 1, middle, last);
}

void SurfaceTree::Tree::try_triangle(int index, const Eigen::Vector3d& p, Best& best) const {
  const TreeTriangle& t = triangles[static_cast<std::size_t>(index)];
  const ClosestOnTriangle closest = closest_on_triangle(t.a, t.ab, t.ac, p);
  const double squared = (p - closest.point).squaredNorm();
  if (squared < best.squared) best = {squared, index, closest};
}

void SurfaceTree::Tree::search(const Eigen::Vector3d& p, Best& best) const {
  WaitingList waiting;
  std::size_t count = 0;
  waiting[count++] = {0, nodes[0].squared_distance(p)};
  while (count > 0) {
    const Waiting next = waiting[--count];
    if (next.squared >= best.squared) continue;
    const Node& node = nodes[static_cast<std::size_t>(next.node)];
    if (node.count > 0) {
      for (int i = 0; i < node.count; ++i) try_triangle(node.first + i, p, best);
      continue;
    }
    Waiting near{node.first, nodes[static_cast<std::size_t>(node.first)].squared_distance(p)};
    Waiting far{node.first + 1, nodes[static_cast<std::size_t>(node.first) + 1].squared_distance(p)};
    if (far.squared < near.squared) std::swap(near, far);
    waiting[count++] = far;
    waiting[count++] = near;
  }
}

std::vector<int> SurfaceTree::Tree::triangles_within(const Eigen::Vector3d& p, double reach) const {
  std::vector<int> found;
  WaitingList waiting;
  std::size_t count = 0;
  waiting[count++] = {0, 0.0};
  while (count > 0) {
    const Node& node = nodes[static_cast<std::size_t>(waiting[--count].node)];
    if (node.squared_distance(p) > reach * reach) continue;
    if (node.count > 0) {
      for (int i = 0; i < node.count; ++i) found.push_back(node.first + i);
    } else {
      waiting[count++] = {node.first, 0.0};
      waiting[count++] = {node.first + 1, 0.0};
    }
  }
  return found;
}

SurfacePoint SurfaceTree::Tree::surface_point(const Eigen::Vector3d& p, const Best& best) const {
  SurfacePoint result;
  result.face = triangles[static_cast<std::size_t>(best.triangle)].face;
  result.point = best.closest.point;
  result.normal = pseudonormal(result.face, best.closest.feature);
  result.distance = std::copysign(std::sqrt(best.squared), (p - result.point).dot(result.normal));
  return result;
}

Eigen::Vector3d SurfaceTree::Tree::pseudonormal(int face, TriangleFeature feature) const {
  const auto f = static_cast<std::size_t>(face);
  if (feature == TriangleFeature::kInside) return face_normal[f];
  if (feature <= TriangleFeature::kCorner2)
    return vertex_normal[static_cast<std::size_t>(faces[f][static_cast<int>(feature)])];
  const auto k = static_cast<std::size_t>(feature) - static_cast<std::size_t>(TriangleFeature::kEdge0);
  return edges.edges[static_cast<std::size_t>(edges.of_face[f][k])].normal;
}

SurfaceTree::SurfaceTree(const Mesh& mesh) {
  auto tree = std::make_unique<Tree>();
  tree->faces = mesh.faces;
  tree->face_normal = face_normals(mesh);
  tree->vertex_normal = vertex_normals(mesh);
  tree->edges = make_mesh_edges(mesh);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (tree->face_normal[f].isZero()) continue;
    const Eigen::Vector3d& a = mesh.vertices[static_cast<std::size_t>(mesh.faces[f][0])];
    const Eigen::Vector3d& b = mesh.vertices[static_cast<std::size_t>(mesh.faces[f][1])];
    const Eigen::Vector3d& c = mesh.vertices[static_cast<std::size_t>(mesh.faces[f][2])];
    tree->triangles.push_back(make_triangle(a, b, c, static_cast<int>(f)));
  }
  require(!tree->triangles.empty(), "a surface needs a face with an area, got ", mesh.faces.size(),
          " faces without");
  tree->nodes.resize(1);
  tree->split(0, 0, static_cast<int>(tree->triangles.size()));
  tree->triangle_of_face.assign(mesh.faces.size(), -1);
  for (std::size_t i = 0; i < tree->triangles.size(); ++i)
    tree->triangle_of_face[static_cast<std::size_t>(tree->triangles[i].face)] = static_cast<int>(i);
  tree_ = std::move(tree);
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree& SurfaceTree::operator=(SurfaceTree&&) noexcept = default;

SurfacePoint SurfaceTree::nearest(const Eigen::Vector3d& p, double limit, int likely_face) const {
  Best best{limit * limit};
  if (likely_face >= 0 && static_cast<std::size_t>(likely_face) < tree_->triangle_of_face.size()) {
    const int index = tree_->triangle_of_face[static_cast<std::size_t>(likely_face)];
    if (index >= 0) tree_->try_triangle(index, p, best);
  }
  tree_->search(p, best);
  if (best.triangle >= 0) return tree_->surface_point(p, best);
  SurfacePoint nothing;
  nothing.distance = limit;
  return nothing;
}

// With c the middle of the cluster, r its radius and d the distance of c: a point of the cluster is at most
// d + r from the surface, so what is nearest to it is at most d + 2 r from c.
std::vector<SurfacePoint> SurfaceTree::nearest(const std::vector<Eigen::Vector3d>& cluster,
                                               int likely_face) const {
  std::vector<SurfacePoint> result;
  if (cluster.empty()) return result;
  result.reserve(cluster.size());
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : cluster) box.extend(p);
  const double radius = 0.5 * box.diagonal().norm();
  const SurfacePoint of_middle = nearest(box.center(), std::numeric_limits<double>::infinity(), likely_face);
  const std::vector<int> candidates =
      tree_->triangles_within(box.center(), (std::abs(of_middle.distance) + 2.0 * radius) * (1.0 + 1e-12));
  int first = tree_->triangle_of_face[static_cast<std::size_t>(of_middle.face)];
  for (const Eigen::Vector3d& p : cluster) {
    Best best{std::numeric_limits<double>::infinity()};
    tree_->try_triangle(first, p, best);
    double distance = std::sqrt(best.squared);
    for (const int index : candidates) {
      const TreeTriangle& t = tree_->triangles[static_cast<std::size_t>(index)];
      const double reach = distance + t.radius;
      if ((p - t.middle).squaredNorm() >= reach * reach) continue;
      const double before = best.squared;
      tree_->try_triangle(index, p, best);
      if (best.squared < before) distance = std::sqrt(best.squared);
    }
    first = best.triangle;
    result.push_back(tree_->surface_point(p, best));
  }
  return result;
}

}  // namespace stonestack::geometry
