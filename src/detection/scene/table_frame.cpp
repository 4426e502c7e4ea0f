#include "stonestack/detection/detect_stones.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "detection/constants.hpp"
#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {
namespace {

constexpr double kCube = 0.005;       // m, side of the cubes in which surface is thinned
constexpr double kAboveTable = 0.01;  // m, lower the sensor's error may pass for a thing

}  // namespace

std::optional<Plane> find_table(const DepthImage& image, const DetectionOptions& options) {
  const auto pixels =
      static_cast<std::size_t>(image.camera.width) * static_cast<std::size_t>(image.camera.height);
  if (image.z.empty() || image.z.size() != pixels) return std::nullopt;
  return find_table(smooth_depth(image, options), std::nullopt, options);
}

Pose camera_over(const Plane& table_C) {
  const Eigen::Vector3d z_C = table_C.normal;
  // Where the image's x points away from the table, its y serves.
  const bool along_x = std::abs(z_C.x()) < 0.99;
  const Eigen::Vector3d axis = along_x ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x_C = (axis - z_C.dot(axis) * z_C).normalized();
  Pose T_C_W = Pose::Identity();
  T_C_W.linear() << x_C, z_C.cross(x_C), z_C;
  T_C_W.translation() = table_C.offset * z_C;
  return T_C_W.inverse();
}

TableView view_of_table(const DepthImage& image, const Plane& table_C, const Pose& T_W_C,
                        const DetectionOptions& options) {
  return view_of_smooth_table(smooth_depth(image, options), table_C, T_W_C);
}

TableView view_of_smooth_table(const DepthImage& depth, const Plane& table_C, const Pose& T_W_C) {
  TableView view;
  constexpr int kNone = std::numeric_limits<int>::min();
  std::set<std::pair<int, int>> cells;
  std::map<std::array<int, 3>, Eigen::Vector3d> cubes;
  // Neighbouring pixels mostly lie in one cell, and in one cube: these need not be searched again.
  std::pair<int, int> last_cell{kNone, kNone};
  std::array<int, 3> last_cube{kNone, kNone, kNone};
  for (int v = 0; v < depth.camera.height; ++v)
    for (int u = 0; u < depth.camera.width; ++u) {
      const double z = depth.at(u, v);
      if (z <= 0) continue;
      const Eigen::Vector3d p_C = z * deproject(depth.camera, u, v);
      const double height = table_C.distance(p_C);
      const bool above = height > kAboveTable && height < kMaxHeight;
      if (!above && !(std::abs(height) <= kTableTolerance)) continue;
      const Eigen::Vector3d p_W = T_W_C * p_C;
      const auto index = [&](int axis, double side) {
        return static_cast<int>(std::floor(p_W[axis] / side));
      };
      if (above) {
        const std::array cube{index(0, kCube), index(1, kCube), index(2, kCube)};
        if (cube != last_cube) cubes.try_emplace(cube, p_W);
        last_cube = cube;
      } else {
        const std::pair cell(index(0, view.cell), index(1, view.cell));
        if (cell != last_cell) cells.insert(cell);
        last_cell = cell;
      }
    }
  for (const auto& [cube, p_W] : cubes) view.above_W.push_back(p_W);
  Eigen::AlignedBox2d box;
  for (const auto& [i, k] : cells) {
    view.p_W.emplace_back(view.cell * (i + 0.5), view.cell * (k + 0.5));
    box.extend(view.p_W.back());
  }
  if (!cells.empty()) view.p_W_middle = box.center();
  return view;
}

}  // namespace stonestack::detection
