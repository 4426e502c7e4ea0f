#include "modelling/rest_on_table.hpp"

#include <algorithm>
#include <numeric>

#include "geometry/polygon.hpp"

namespace stonestack::modelling {
namespace {

constexpr double kSurfaceLooksDown = -0.3;  // z of the normal of surface that may touch a table
constexpr double kWithinContact = 0.008;    // m, of the centre of mass within the contact: design choice

}  // namespace

void rest_on(ObjectModel& model, const HeightBelow& height) {
  std::vector<Eigen::Vector3d>& vertices = model.mesh.vertices;
  const std::vector<Eigen::Vector3d> normals = geometry::vertex_normals(model.mesh);
  struct Place {
    std::size_t vertex;
    double below;  ///< height of what is below it
    double gap;
  };
  std::vector<Place> underside;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    if (model.seen[k] != 0 || normals[k].z() >= kSurfaceLooksDown) continue;
    if (const auto below = height(vertices[k].head<2>()))
      underside.push_back({k, *below, vertices[k].z() - *below});
  }
  std::sort(underside.begin(), underside.end(), [](const Place& a, const Place& b) { return a.gap < b.gap; });
  const Eigen::Vector2d p_M = geometry::mass_properties(model.mesh, 1.0).p_O_M.head<2>();
  const auto carries = [&](std::size_t count) {
    std::vector<Eigen::Vector2d> points;
    for (std::size_t k = 0; k < count; ++k) points.push_back(vertices[underside[k].vertex].head<2>());
    return geometry::margin(geometry::convex_hull(std::move(points)), p_M) >= kWithinContact;
  };
  std::vector<std::size_t> counts(underside.size());
  std::iota(counts.begin(), counts.end(), std::size_t{1});  // a wider contact carries what a part of it does
  const auto first =
      std::partition_point(counts.begin(), counts.end(), [&](std::size_t count) { return !carries(count); });
  const std::size_t contact = first == counts.end() ? underside.size() : *first;
  for (std::size_t k = 0; k < underside.size(); ++k)
    if (k < contact || underside[k].gap < 0.0) vertices[underside[k].vertex].z() = underside[k].below;
}

void rest_on_table(ObjectModel& model) {
  rest_on(model, [](const Eigen::Vector2d&) { return 0.0; });
  for (Eigen::Vector3d& p : model.mesh.vertices) p.z() = std::max(p.z(), 0.0);
}

}  // namespace stonestack::modelling
