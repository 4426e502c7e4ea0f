#include "stacking/free_places.hpp"

#include <algorithm>
#include <cmath>

#include "physics/settle.hpp"
#include "physics/shape.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kRaster = 0.05;     // m between places that are tried
constexpr double kSeen = 0.6;        // of the field, about its middle: what the camera sees of it for sure
constexpr double kClearance = 0.03;  // m between stones that lie side by side, for the fingers
constexpr double kExtent = 0.75;     // of the bounding radius: stones are longer than wide
constexpr double kGap = 0.002;       // m, that it falls
constexpr double kRolls = 0.15;      // rad, by which it rests otherwise than it is held
constexpr std::size_t kMaxPlaces = 8;

double radius(const ShapeList& shapes, StoneIndex stone) {
  return kExtent * at(shapes, stone)->radius;
}

/// As it is held, a little above the table.
Pose above_table(const ShapeList& shapes, const PlacedStone& held) {
  const double low = lowest(*at(shapes, held.stone), held.T_W_O);
  return Eigen::Translation3d(0, 0, kGap - low) * held.T_W_O;
}

/// How the stone would come to rest on the table from there: rotation, and height of O.
Pose rest_on_table(const ShapeList& shapes, StoneIndex stone, const Pose& T_W_O_lifted) {
  SettleOptions options;
  options.world.friction = 0.5;  // it shall roll to rest, not slide about
  options.max_travel = 0.20;     // m
  options.seconds = 2.0;
  return settle(shapes, Stack{}, stone, T_W_O_lifted, options).T_W_O;
}

}  // namespace

std::vector<Pose> free_places(const ShapeList& shapes, const CellLayout& layout,
                              const Arrangement& arrangement, const PlacedStone& held) {
  const StoneIndex stone = held.stone;
  const Pose lifted = above_table(shapes, held), rest = rest_on_table(shapes, stone, lifted);
  const Eigen::Vector3d p_O_M = at(shapes, stone)->mass.p_O_M;
  std::vector<std::pair<double, Eigen::Vector2d>> places;
  const Eigen::Vector2d half = 0.5 * kSeen * layout.field_size;
  for (double x = -half.x(); x <= half.x(); x += kRaster)
    for (double y = -half.y(); y <= half.y(); y += kRaster) {
      const Eigen::Vector2d place = layout.field_centre + Eigen::Vector2d(x, y);
      double clearance = 1.0;
      for (const auto& other : arrangement.loose) {
        const Eigen::Vector3d p_W_M = other.T_W_O * at(shapes, other.stone)->mass.p_O_M;
        clearance = std::min(clearance, (p_W_M.head<2>() - place).norm() - radius(shapes, other.stone) -
                                            radius(shapes, stone));
      }
      if (clearance < kClearance) continue;
      places.emplace_back(clearance, place);
    }
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  places.resize(std::min(kMaxPlaces, places.size()));
  std::vector<Pose> poses;
  const auto add = [&](const Pose& T_W_O) {
    const Eigen::Vector3d p_W_M = T_W_O * p_O_M;
    for (int quarter = 0; quarter < 4; ++quarter)
      for (const auto& [clearance, place] : places)
        poses.push_back(Eigen::Translation3d(place.x(), place.y(), p_W_M.z()) *
                        Eigen::AngleAxisd(quarter * M_PI / 2, Eigen::Vector3d::UnitZ()) *
                        Eigen::Translation3d(-p_W_M) * T_W_O);
  };
  add(rest);
  if (difference(lifted, rest).angle > kRolls) add(lifted);
  return poses;
}

}  // namespace stonestack::stacking
