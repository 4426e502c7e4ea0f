#include "search/resting_height.hpp"
#include "physics/shape.hpp"

#include <cmath>

namespace stonestack::search {

double resting_height(std::span<const BodyPose> stack, const BodyPose& body) {
  constexpr double kCell = 0.003;
  SurfaceGrid grid;
  grid.centre = body.p_W_M.head<2>();
  grid.cell = kCell;
  grid.half = static_cast<int>(std::ceil(body.stone->radius / kCell)) + kRun;
  const TopSurface surface = top_surface(stack, grid, 0.0);
  UndersideOptions options;
  options.cell = kCell;
  options.stride = surface.heights.stride;
  options.cut = 2.0 * body.stone->radius;
  GapField field;
  lay(surface, make_underside(body.stone->vertices_M, body.stone->faces, body.R_W_O, options), 0, 0, 0.001,
      &field);
  return static_cast<double>(field.highest);
}

Pose lifted_clear(const ShapeList& shapes, const Stack& stack, const PlacedStone& placed) {
  constexpr double kClearance = 0.001;
  std::vector<StoneGeometry> geometry;
  geometry.reserve(stack.stones.size() + 1);
  std::vector<BodyPose> bodies;
  const auto body_of = [&](const PlacedStone& stone) {
    geometry.push_back(stone_geometry(*at(shapes, stone.stone)));
    return body_pose(geometry.back(), stone.T_W_O);
  };
  for (const PlacedStone& below : stack.stones) bodies.push_back(body_of(below));
  BodyPose body = body_of(placed);
  body.p_W_M.z() = resting_height(bodies, body) + kClearance;
  return stone_pose(body);
}

}  // namespace stonestack::search
