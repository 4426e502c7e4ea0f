#include "stone/geodesic.hpp"

#include <array>
#include <cmath>
#include <map>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

/// A vertex as weights on at most three corners of the icosahedron: the same for both faces of an edge.
using Weights = std::map<int, int>;

const std::array<Eigen::Vector3d, 12>& corners() {
  static const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  static const std::array<Eigen::Vector3d, 12> points = {{{-1, g, 0},
                                                          {1, g, 0},
                                                          {-1, -g, 0},
                                                          {1, -g, 0},
                                                          {0, -1, g},
                                                          {0, 1, g},
                                                          {0, -1, -g},
                                                          {0, 1, -g},
                                                          {g, 0, -1},
                                                          {g, 0, 1},
                                                          {-g, 0, -1},
                                                          {-g, 0, 1}}};
  return points;
}

/// The twenty faces: every three corners that are one edge (length 2) apart, counter-clockwise from outside.
std::vector<Eigen::Vector3i> icosahedron_faces() {
  const auto& p = corners();
  const auto near = [&](int a, int b) { return (p[a] - p[b]).squaredNorm() < 4.1; };
  std::vector<Eigen::Vector3i> faces;
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c) {
        if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
        const bool outward = (p[b] - p[a]).cross(p[c] - p[a]).dot(p[a]) > 0.0;
        faces.emplace_back(a, outward ? b : c, outward ? c : b);
      }
  return faces;
}

}  // namespace

Mesh make_geodesic(int frequency) {
  require(frequency >= 1 && frequency <= 200, "frequency must be in [1, 200], got ", frequency);
  Mesh mesh;
  std::map<Weights, int> known;
  const auto vertex = [&](const Eigen::Vector3i& face, int i, int j) {
    const int weight[3] = {frequency - i - j, i, j};
    Weights weights;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      if (weight[k] > 0) weights[face[k]] = weight[k];
    for (const auto& [corner, share] : weights) point += corners()[corner] * share;
    const auto [entry, fresh] = known.emplace(weights, static_cast<int>(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(point.normalized());
    return entry->second;
  };
  for (const Eigen::Vector3i& face : icosahedron_faces())
    for (int i = 0; i < frequency; ++i)
      for (int j = 0; i + j < frequency; ++j) {
        const int a = vertex(face, i, j), b = vertex(face, i + 1, j), c = vertex(face, i, j + 1);
        mesh.faces.emplace_back(a, b, c);
        if (i + j + 1 < frequency) mesh.faces.emplace_back(b, vertex(face, i + 1, j + 1), c);
      }
  return mesh;
}

}  // namespace stonestack::stone
