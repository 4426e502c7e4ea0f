#include "stacking/unknown_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/constants.hpp"
#include "detection/scene/preprocess.hpp"
#include "geometry/convex_pieces.hpp"
#include "search/find_stack.hpp"
#include "stacking/arrangement.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kCube = 0.005;            // m: one point of surface a cube
constexpr double kBeside = 0.001;          // m that seen surface may be off: stones lie 5 mm beside it
constexpr double kAtSite = 0.15;           // m from the site
constexpr double kOverTower = 0.010;       // m above the tower's top: models err by less
constexpr double kAtBase = 0.30;           // m from the robot's base, which the camera may see, too
constexpr double kOverField = 0.3;         // m beyond the field
constexpr double kShownSurface = 0.010;    // m along a ray: poses of the camera and depth err by less
constexpr double kSamePlaceAround = 0.01;  // m about an object: what a view may show more of it

/// Does the image show this place: the point itself, or what lies behind it?
bool shows(const DepthImage& depth, const Pose& T_W_C, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = T_W_C.inverse() * p_W;
  if (!(p_C.z() > 0.0)) return false;
  const Eigen::Vector2d pixel = project(depth.camera, p_C).array().round();
  if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < depth.camera.width &&
        pixel.y() < depth.camera.height))
    return false;
  const double seen = depth.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  return seen > p_C.z() - kShownSurface;
}

/// Surface above the table in all views, a point in each cube; with it what was seen before, `earlier_W`,
/// where no view shows that place: it lies outside of them, or something hides it.
std::vector<Eigen::Vector3d> surface_in(const Views& views, const DetectionOptions& options,
                                        std::vector<Eigen::Vector3d> earlier_W = {}) {
  std::map<std::array<int, 3>, Eigen::Vector3d> cubes;
  const auto add = [&](const Eigen::Vector3d& p_W) {
    const Eigen::Vector3d cube = (p_W / kCube).array().floor();
    cubes.try_emplace({static_cast<int>(cube.x()), static_cast<int>(cube.y()), static_cast<int>(cube.z())},
                      p_W);
  };
  for (const CameraView& view : views) {
    const DepthImage depth = detection::smooth_depth(view.image, options);
    const auto table_C = detection::find_table(depth, std::nullopt, options);
    if (!table_C) continue;
    for (const Eigen::Vector3d& p_W : detection::view_of_smooth_table(depth, *table_C, view.T_W_C).above_W)
      add(p_W);
    std::erase_if(earlier_W, [&](const Eigen::Vector3d& p_W) { return shows(depth, view.T_W_C, p_W); });
  }
  for (const Eigen::Vector3d& p_W : earlier_W) add(p_W);
  std::vector<Eigen::Vector3d> surface;
  for (const auto& [cube, p_W] : cubes) surface.push_back(p_W);
  return surface;
}

/// Upright prism with sixteen sides about what is seen of a thing, from the table up.
Mesh prism_about(const std::vector<Eigen::Vector3d>& surface_W) {
  constexpr int kSides = 16;
  std::array<double, kSides> reach;
  reach.fill(-1e9);
  double highest = 0.0;
  const auto direction = [](int k) {
    return Eigen::Vector2d(std::cos(kTwoPi * k / kSides), std::sin(kTwoPi * k / kSides));
  };
  for (const Eigen::Vector3d& p_W : surface_W) {
    highest = std::max(highest, p_W.z());
    for (int k = 0; k < kSides; ++k) {
      auto& furthest = reach[static_cast<std::size_t>(k)];
      furthest = std::max(furthest, direction(k).dot(p_W.head<2>()) + kBeside);
    }
  }
  Mesh corners;  // where neighbouring sides meet
  for (int k = 0; k < kSides; ++k) {
    Eigen::Matrix2d sides;
    sides << direction(k).transpose(), direction(k + 1).transpose();
    const Eigen::Vector2d corner =
        sides.inverse() * Eigen::Vector2d(reach[static_cast<std::size_t>(k)],
                                          reach[static_cast<std::size_t>((k + 1) % kSides)]);
    for (const double z : {0.0, highest + kBeside}) corners.vertices.emplace_back(corner.x(), corner.y(), z);
  }
  return convex_hull(corners);
}

bool is_of_interest(const CellLayout& layout, const Eigen::Vector2d& p_W) {
  const Eigen::Vector2d off = (p_W - layout.field_centre).cwiseAbs() - 0.5 * layout.field_size;
  const bool near = off.maxCoeff() < kOverField || (p_W - layout.site).norm() < kOverField;
  return near && (p_W - layout.T_W_R.translation().head<2>()).norm() > kAtBase;
}

std::vector<UnknownThing> things_in(const Workcell& w, const Views& views,
                                    const std::vector<PlacedStone>& stones,
                                    const std::vector<Eigen::Vector3d>& earlier_W) {
  auto things = find_stack(w.models.shapes, stones, w.cell.layout.site,
                           surface_in(views, w.options.detection, earlier_W))
                    .unknown;
  std::erase_if(things, [&](const UnknownThing& thing) { return !is_of_interest(w.cell.layout, thing.p_W); });
  return things;
}

void add_thing(std::vector<Obstacle>& obstacles, const std::string& what, const UnknownThing& thing) {
  obstacles.push_back(obstacle_about(thing, concat(what, " ", obstacles.size() + 1)));
}

}  // namespace

Eigen::AlignedBox2d ground_of(const Obstacle& obstacle) {
  Eigen::AlignedBox2d ground;
  for (const Mesh& piece : obstacle.pieces)
    for (const Eigen::Vector3d& p : piece.vertices) ground.extend((obstacle.T_W_O * p).head<2>());
  return ground;
}

Obstacle obstacle_about(const UnknownThing& thing, const std::string& name) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.pieces = {prism_about(thing.surface_W)};
  return obstacle;
}

std::vector<UnknownThing> unknown_things(const Workcell& w, const Views& views,
                                         const std::vector<PlacedStone>& stones) {
  auto things = things_in(w, views, stones, {});
  std::stable_sort(things.begin(), things.end(), [](const UnknownThing& a, const UnknownThing& b) {
    return a.surface_W.size() > b.surface_W.size();
  });
  return things;
}

std::vector<Obstacle> objects_above_table(const Views& views, const DetectionOptions& options,
                                          const std::string& what) {
  std::vector<Obstacle> obstacles;
  for (const UnknownThing& thing : find_stack({}, {}, std::nullopt, surface_in(views, options)).unknown)
    add_thing(obstacles, what, thing);
  return obstacles;
}

std::vector<UnknownThing> unknown_objects(const Workcell& w, const Views& views, const WorldEstimate& world) {
  std::vector<PlacedStone> stones;
  for (const StoneEstimate& stone : world.stack) stones.push_back({stone.stone, stone.T_W_O_seen});
  const double top = top_height(w.models.shapes, stones);
  for (const StoneEstimate& stone : world.loose) stones.push_back({stone.stone, stone.T_W_O_seen});
  auto things = things_in(w, views, stones, w.unknown_surface_W);
  std::erase_if(things, [&](const UnknownThing& thing) {
    const bool at_tower = !world.stack.empty() && (thing.p_W - w.cell.layout.site).norm() <= kAtSite;
    return at_tower && thing.highest <= top + kOverTower;
  });
  return things;
}

void drop_known_objects(const ShapeList& shapes, const std::vector<StoneIndex>& known,
                        std::span<const Obstacle> unknown, std::vector<Sighting>& sightings) {
  std::erase_if(sightings, [&](const Sighting& seen) {
    if (std::find(known.begin(), known.end(), seen.stone) != known.end()) return false;
    const Eigen::Vector3d p_W_M = com_of(shapes, {seen.stone, seen.T_W_O});
    return std::any_of(unknown.begin(), unknown.end(), [&](const Obstacle& object) {
      return ground_of(object).exteriorDistance(p_W_M.head<2>().eval()) < kSamePlaceAround;
    });
  });
}

}  // namespace stonestack::stacking
