#include "stonestack/physics/equilibrium.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2.h>
#include <CGAL/Polyline_simplification_2/Squared_distance_cost.h>
#include <CGAL/Polyline_simplification_2/Stop_above_cost_threshold.h>
#include <CGAL/Polyline_simplification_2/simplify.h>
#include <CGAL/convex_hull_2.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "geometry/polygon.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polygon = CGAL::Polygon_2<Kernel>;

constexpr double kMerge = 0.001;       // m: nearer points count once
constexpr double kSimplify = 0.00025;  // m: corners nearer than this to their neighbours' line are left out

std::vector<Contact> distinct(std::span<const Contact> contacts, double max_gap) {
  std::vector<Contact> kept;
  for (const Contact& c : contacts) {
    if (!(c.gap <= max_gap)) continue;
    const bool known = std::any_of(kept.begin(), kept.end(),
                                   [&](const Contact& o) { return (o.p_W - c.p_W).norm() < kMerge; });
    if (!known) kept.push_back(c);
  }
  return kept;
}

/// Convex hull, counter-clockwise, without corners that hardly stick out.
Polygon2 simplified_hull(const Polygon2& points) {
  namespace PS = CGAL::Polyline_simplification_2;
  std::vector<Kernel::Point_2> in, out;
  for (const auto& p : points) in.emplace_back(p.x(), p.y());
  CGAL::convex_hull_2(in.begin(), in.end(), std::back_inserter(out));
  Polygon polygon(out.begin(), out.end());
  if (polygon.size() > 3)
    polygon = PS::simplify(polygon, PS::Squared_distance_cost(),
                           PS::Stop_above_cost_threshold(kSimplify * kSimplify));
  Polygon2 corners;
  for (const auto& p : polygon.container()) corners.emplace_back(p.x(), p.y());
  return corners;
}

}  // namespace

SupportPolygon support_polygon(std::span<const Contact> contacts, const Eigen::Vector3d& p_W_com,
                               double max_gap) {
  SupportPolygon out;
  const std::vector<Contact> points = distinct(contacts, max_gap);
  out.contacts = static_cast<int>(points.size());
  if (points.empty()) {
    out.margin = -1.0;
    return out;
  }
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), mean = Eigen::Vector3d::Zero();
  for (const Contact& c : points) {
    normal += c.n_W;
    mean += c.p_W / static_cast<double>(points.size());
  }
  if (normal.norm() > 1e-9) out.n_W = normal.normalized();
  if (out.n_W.z() < 0) out.n_W = -out.n_W;
  const Eigen::Vector3d u = out.n_W.unitOrthogonal(), v = out.n_W.cross(u);

  Polygon2 flat, level;
  for (const Contact& c : points) {
    flat.emplace_back(u.dot(c.p_W - mean), v.dot(c.p_W - mean));
    level.emplace_back(c.p_W.head<2>());
  }
  const Polygon2 corners = simplified_hull(flat);
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  if (corners.size() >= 3 && area(corners) > 0.0) {
    out.area = area(corners);
    centre = centroid(corners);
  }
  for (const auto& c : corners) out.corners_W.push_back(mean + c.x() * u + c.y() * v);
  out.p_W_centroid = mean + centre.x() * u + centre.y() * v;
  out.margin = margin(simplified_hull(level), p_W_com.head<2>());
  return out;
}

}  // namespace stonestack::physics
