#include "search/top_surface.hpp"

#include <algorithm>
#include <cmath>

#include "search/held_support.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

/// Raises the raster by the upper side of a stone.
void raise_by(HeightRaster& raster, const BodyPose& body) {
  std::vector<Eigen::Vector3d> vertices_W(body.stone->vertices_M.size());
  for (std::size_t k = 0; k < vertices_W.size(); ++k)
    vertices_W[k] = body.R_W_O * body.stone->vertices_M[k] + body.p_W_M;
  raise_to(raster, vertices_W, body.stone->faces, Winding::kCounterclockwise);
}

constexpr double kInterfaceCell = 0.003;  ///< [m]
constexpr double kRestGap = 0.0008;       ///< between a stone and what it is taken to rest on [m]

Rest rest_on(const std::vector<Eigen::Vector3d>& points_W) {
  Rest rest;
  std::vector<Eigen::Vector2d> seen;
  for (const Eigen::Vector3d& p_W : points_W) {
    seen.push_back(p_W.head<2>());
    rest.z += p_W.z() / static_cast<double>(points_W.size());
  }
  rest.polygon_W = convex_hull(seen);
  return rest;
}

/// Contacts of a stone with the one below (or the table) at the poses that they have.
Rest estimated_rest(const BodyPose* below, const BodyPose& above) {
  const int half = static_cast<int>(std::ceil(above.stone->radius / kInterfaceCell)) + kRun;
  const SurfaceGrid grid{above.p_W_M.head<2>(), kInterfaceCell, half};
  TopSurface surface = top_surface({}, grid, 0.0);
  if (below != nullptr) {
    std::fill(surface.heights.z.begin(), surface.heights.z.end(), kNoSurface);
    raise_by(surface.heights, *below);
  }
  UndersideOptions options;
  options.cell = kInterfaceCell;
  options.stride = surface.heights.stride;
  options.cut = 0.08;
  const Underside underside =
      make_underside(above.stone->vertices_M, above.stone->faces, above.R_W_O, options);
  GapField field;
  lay(surface, underside, 0, 0, kRestGap, &field);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t k = 0; k < field.d.size(); ++k) {
    if (field.d[k] < field.highest - static_cast<float>(kRestGap)) continue;
    const int node = field.node(k);
    const auto z = static_cast<double>(surface.heights.z[static_cast<std::size_t>(node)]);
    if (z <= static_cast<double>(kNoSurface) + 1.0) continue;
    const Eigen::Vector2d at = surface.heights.node(node);
    points.emplace_back(at.x(), at.y(), z);
  }
  return rest_on(points);
}

}  // namespace

StoneGeometry stone_geometry(const ContactShape& shape) {
  require(!shape.scan.faces.empty(), "contact shape ", shape.name, " has no scan mesh");
  StoneGeometry stone;
  stone.vertices_M.reserve(shape.scan.vertices.size());
  for (const Eigen::Vector3d& p_O : shape.scan.vertices) {
    stone.vertices_M.emplace_back(p_O - shape.mass.p_O_M);
    stone.radius = std::max(stone.radius, stone.vertices_M.back().norm());
  }
  stone.faces = shape.scan.faces;
  stone.p_O_M = shape.mass.p_O_M;
  stone.mass = shape.mass.mass;
  return stone;
}

BodyPose body_pose(const StoneGeometry& stone, const Pose& T_W_O) {
  return {&stone, T_W_O.linear(), T_W_O * stone.p_O_M};
}

Pose stone_pose(const BodyPose& body) {
  Pose T_W_O = Pose::Identity();
  T_W_O.linear() = body.R_W_O;
  T_W_O.translation() = body.p_W_M - body.R_W_O * body.stone->p_O_M;
  return T_W_O;
}

TopSurface top_surface(std::span<const BodyPose> may_touch, std::span<const BodyPose> kept_clear,
                       const SurfaceGrid& grid, double clean_height) {
  TopSurface surface{HeightRaster(grid.centre, grid.cell, grid.half), {}};
  std::vector<float>& z = surface.heights.z;
  for (const BodyPose& body : may_touch) raise_by(surface.heights, body);
  HeightRaster rest(grid.centre, grid.cell, grid.half);
  std::fill(rest.z.begin(), rest.z.end(), 0.0F);
  for (const BodyPose& body : kept_clear) raise_by(rest, body);
  surface.may_touch.resize(z.size());
  for (std::size_t k = 0; k < z.size(); ++k) {
    const float clear = rest.z[k] + static_cast<float>(clean_height);
    surface.may_touch[k] = z[k] >= clear ? 1 : 0;
    z[k] = std::max(z[k], clear);
  }
  return surface;
}

TopSurface top_surface(std::span<const BodyPose> stack, const SurfaceGrid& grid, double clean_height) {
  if (!stack.empty()) return top_surface(stack.last(1), stack.first(stack.size() - 1), grid, clean_height);
  TopSurface table{HeightRaster(grid.centre, grid.cell, grid.half), {}};
  std::fill(table.heights.z.begin(), table.heights.z.end(), 0.0F);
  table.may_touch.assign(table.heights.z.size(), 1);
  return table;
}

std::vector<Rest> rests_of(const ShapeList& shapes, const Stack& stack) {
  std::vector<std::vector<Eigen::Vector3d>> points(stack.stones.size());
  for (const Contact& contact : geometric_contacts(shapes, stack, kRestGap))
    if (contact.below == contact.above - 1 || (contact.below == kTable && contact.above == 0))
      points[static_cast<std::size_t>(contact.above)].push_back(contact.p_W);
  std::vector<Rest> rests;
  for (const auto& of_stone : points) rests.push_back(rest_on(of_stone));
  return rests;
}

Interface interface_under(std::span<const BodyPose> bodies) {
  Interface under;
  for (const BodyPose& body : bodies) {
    under.mass_above += body.stone->mass;
    under.moment_above += body.stone->mass * body.p_W_M;
  }
  return under;
}

std::vector<Interface> interfaces(const StackBodies& stack) {
  const std::vector<BodyPose>& bodies = stack.bodies;
  std::vector<Interface> list = held_interfaces(bodies, stack.held);
  for (std::size_t k = list.size(); k < bodies.size(); ++k) {
    Interface& under = list.emplace_back(interface_under(std::span(bodies).subspan(k)));
    under.rest = k < stack.rests.size() ? stack.rests[k]
                                        : estimated_rest(k == 0 ? nullptr : &bodies[k - 1], bodies[k]);
  }
  return list;
}

double tipping_limit(std::span<const Interface> interfaces, double mass, const Eigen::Vector3d& p_W_M) {
  double min = 1e300;
  for (const Interface& at : interfaces) {
    const Eigen::Vector3d p_W_com = (at.moment_above + mass * p_W_M) / (at.mass_above + mass);
    const double height = std::max(p_W_com.z() - at.rest.z, 1e-3);
    min = std::min(min, margin(at.rest.polygon_W, p_W_com.head<2>()) / height);
  }
  return min;
}

}  // namespace stonestack::search
