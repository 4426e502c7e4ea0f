#include "search/wall/wall_sides.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/polygon.hpp"
#include "physics/shape.hpp"
#include "search/constants.hpp"
#include "search/orientations.hpp"
#include "search/parallel.hpp"

namespace stonestack::search {
namespace {

constexpr double kFirmOnTable = 0.006;  // m: centre of mass to the rim of the contacts, at least
constexpr double kSteepTop = 0.5;       // rise over run of a plate on top, at most
constexpr double kTopTouch = 0.002;     // m: what is nearer to the plate carries it
constexpr double kWallOffset = 0.05;    // m about the place of a stone that a raster covers, beside the stone
constexpr double kLevelOnTable = 0.01;  // rise over run that needs no further turning
constexpr int kTableLevellings = 3;     // rounds of turning a stone level, at most
constexpr std::size_t kSidesPerStone = 16;

Eigen::Matrix3d upside_down() {
  return Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
}

/// A stone on the table, levelled; empty if it does not lie on that side.
std::optional<std::pair<Eigen::Matrix3d, Landing>> lying(const StackField& table, const StoneGeometry& stone,
                                                         Eigen::Matrix3d R_W_O) {
  GapField buffer;
  for (int round = 0;; ++round) {
    const Underside side = make_underside(stone.vertices_M, stone.faces, R_W_O, underside_options(table));
    const Landing landing = land_on_table(table, side, &buffer);
    if (!landing.holds) return std::nullopt;
    if (std::hypot(landing.a, landing.b) < kLevelOnTable || round == kTableLevellings)
      return std::pair(R_W_O, landing);
    R_W_O = levelled(R_W_O, landing);
  }
}

/// Convex hull of a stone seen from above, about its centre of mass.
Polygon2 outline_of(const StoneGeometry& stone, const Eigen::Matrix3d& R_W_O) {
  std::vector<Eigen::Vector2d> seen;
  for (const Eigen::Vector3d& v : stone.vertices_M) seen.emplace_back((R_W_O * v).head<2>());
  return convex_hull(std::move(seen));
}

/// The stone turned about the vertical so that the smallest rectangle about its outline lies along the wall,
/// the long side in x: turns that are tried begin there, and a brick can stand square to the wall.
Eigen::Matrix3d along_the_wall(const StoneGeometry& stone, const Eigen::Matrix3d& R_W_O) {
  const Polygon2 outline = outline_of(stone, R_W_O);
  double smallest = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d best = R_W_O;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Eigen::Vector2d side = outline[(k + 1) % outline.size()] - outline[k];
    const Eigen::Matrix3d turned = yaw_rotation(-std::atan2(side.y(), side.x())) * R_W_O;
    const Extents extents = extents_of(stone, turned);
    const Eigen::Vector2d size = extents.max - extents.min;
    if (size.prod() > smallest - 1e-9) continue;
    smallest = size.prod();
    best = size.x() >= size.y() ? turned : Eigen::Matrix3d(yaw_rotation(M_PI / 2) * turned);
  }
  return best;
}

std::optional<TopFace> top_of(const StackField& table, const StoneGeometry& stone,
                              const Eigen::Matrix3d& R_W_O) {
  GapField field;
  const Eigen::Matrix3d R_flipped = upside_down() * R_W_O;
  const Underside side = make_underside(stone.vertices_M, stone.faces, R_flipped, underside_options(table));
  lay(table.surface, side, 0, 0, 0.08, &field);
  const GapRest rest = solve_rest(field, table.surface, kSteepTop);
  if (!rest.rests) return std::nullopt;
  TopFace top;
  top.height = rest.height;
  top.margin = contact_of(field, rest, table.surface, kTopTouch).margin;
  Landing tilt;
  tilt.a = rest.a;
  tilt.b = rest.b;
  top.normal_O = -(R_flipped.transpose() * levelled(Eigen::Matrix3d::Identity(), tilt).transpose().col(2));
  return top;
}

/// Worth of a side for a wall: firm below, level and broad on top.
double worth_of_side(const Landing& landing, const TopFace& top, const Eigen::Matrix3d& R_W_O) {
  const double level = std::max(0.0, (R_W_O * top.normal_O).z());
  return std::min(landing.margin, 0.03) * level * (0.2 + std::min(std::max(top.margin, 0.0), 0.03) / 0.03);
}

}  // namespace

Extents extents_of(const StoneGeometry& stone, const Eigen::Matrix3d& R_W_O) {
  Extents extents{{1e9, 1e9}, {-1e9, -1e9}};
  for (const Eigen::Vector3d& v : stone.vertices_M) {
    const Eigen::Vector2d p = (R_W_O * v).head<2>();
    extents.min = extents.min.cwiseMin(p);
    extents.max = extents.max.cwiseMax(p);
  }
  return extents;
}

WallSide standing_side(const SearchContext& context, const StoneGeometry& stone,
                       const Eigen::Matrix3d& R_W_O) {
  const SearchOptions& o = *context.options;
  const LooseStone alone{kNoStone, &stone, {}, stone.radius, nullptr};
  const StackField table = stack_field({}, {&alone, 1}, {0, 0}, o.grid, o);
  WallSide side{R_W_O, {}, {}, extents_of(stone, R_W_O), area(outline_of(stone, R_W_O)), {}};
  if (const auto top = top_of(table, stone, R_W_O)) {
    side.top = *top;
    return side;
  }
  for (const Eigen::Vector3d& v : stone.vertices_M)
    side.top.height = std::max(side.top.height, (R_W_O * v).z());
  side.top.normal_O = R_W_O.transpose() * Eigen::Vector3d::UnitZ();
  return side;
}

int raster_half(const SearchContext& context, double cell) {
  double radius = 0.0;
  for (const PlacedStone& placed : context.available)
    radius = std::max(radius, at(context.geometry, placed.stone).radius);
  return static_cast<int>(std::ceil((radius + kWallOffset) / cell)) + kRun;
}

std::vector<WallStone> wall_stones(const SearchContext& context, int stride) {
  const SearchOptions& o = *context.options;
  std::vector<LooseStone> loose = loose_stones(context);
  const StackField table = stack_field({}, loose, {0, 0}, o.grid, o);
  UndersideOptions of_wall = underside_options(table);
  of_wall.stride = stride;
  std::vector<WallStone> stones(loose.size());
  run_tasks(o.threads, loose.size(), [&](std::size_t s) {
    const StoneGeometry& geometry = *loose[s].geometry;
    stones[s] = {loose[s].stone, &geometry, {}};
    struct Base {
      Eigen::Matrix3d R;
      Landing landing;
      TopFace top;
    };
    std::vector<Base> bases;
    for (const Eigen::Matrix3d& R : loose[s].orientations) {
      const auto on_table = lying(table, geometry, R);
      if (!on_table || on_table->second.margin < kFirmOnTable) continue;
      const bool known = std::any_of(bases.begin(), bases.end(), [&](const Base& base) {
        return base.R.row(2).dot(on_table->first.row(2)) > 0.998;
      });
      if (known) continue;
      if (const auto top = top_of(table, geometry, on_table->first))
        bases.push_back({along_the_wall(geometry, on_table->first), on_table->second, *top});
    }
    std::stable_sort(bases.begin(), bases.end(), [](const Base& p, const Base& q) {
      return worth_of_side(p.landing, p.top, p.R) > worth_of_side(q.landing, q.top, q.R);
    });
    bases.resize(std::min(bases.size(), kSidesPerStone));
    for (const Base& base : bases)
      for (int yaw = 0; yaw < o.yaws; ++yaw) {
        const Eigen::Matrix3d R = yaw_rotation(2.0 * M_PI * yaw / o.yaws) * base.R;
        stones[s].sides.push_back({R, base.landing, base.top, extents_of(geometry, R),
                                   area(outline_of(geometry, R)),
                                   make_underside(geometry.vertices_M, geometry.faces, R, of_wall)});
      }
  });
  std::erase_if(stones, [](const WallStone& stone) { return stone.sides.empty(); });
  return stones;
}

}  // namespace stonestack::search
