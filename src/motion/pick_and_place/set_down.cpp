#include "motion/pick_and_place/set_down.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/footprint.hpp"

namespace stonestack::motion {
namespace {

/// True if the line along some side of `a` has `b`, shifted by `shift`, at least `gap` (m) on its other side.
bool side_parts(const Polygon2& a, const Polygon2& b, const Eigen::Vector2d& shift, double gap) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d side = a[(i + 1) % a.size()] - a[i];
    const Eigen::Vector2d n = Eigen::Vector2d(side.y(), -side.x()).normalized();  // outward
    if (std::all_of(b.begin(), b.end(),
                    [&](const Eigen::Vector2d& p) { return n.dot(p + shift - a[i]) >= gap; }))
      return true;
  }
  return false;
}

}  // namespace

Pose standing(const Stone& stone, const Eigen::Quaterniond& R_W_O, const Eigen::Vector2d& p_W_at,
              double table_z) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& v : stone.scan.vertices) lowest = std::min(lowest, (R_W_O * v).z());
  const Eigen::Vector3d p_W_M = R_W_O * stone.mass.p_O_M;
  return make_pose({p_W_at.x() - p_W_M.x(), p_W_at.y() - p_W_M.y(), table_z - lowest}, R_W_O);
}

SetDownPlaces::SetDownPlaces(const PlanningScene& scene, const PickAndPlaceTask& task,
                             const RegraspOptions& options)
    : scene_(scene), task_(task), options_(options) {
  const Eigen::Vector2d here = (task.T_W_O_pick * task.stone->mass.p_O_M).head<2>();
  const int steps = static_cast<int>(options.around / options.spacing);
  for (int ix = -steps; ix <= steps; ++ix)
    for (int iy = -steps; iy <= steps; ++iy)
      spots_.push_back(here + options.spacing * Eigen::Vector2d(ix, iy));
  std::stable_sort(spots_.begin(), spots_.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (a - here).squaredNorm() < (b - here).squaredNorm() - 1e-9;
  });
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (static_cast<int>(i) != task.object && !scene.objects[i].pieces.empty())
      taken_.push_back(footprint(scene.objects[i].pieces, scene.objects[i].T_W_object));
  taken_.push_back(footprint(task.stone->pieces, task.T_W_O_place));
}

bool SetDownPlaces::has_clearance(const Polygon2& print, const Eigen::Vector2d& p_W_shift) const {
  return std::all_of(taken_.begin(), taken_.end(), [&](const Polygon2& other) {
    return side_parts(other, print, p_W_shift, options_.apart) ||
           side_parts(print, other, -p_W_shift, options_.apart);
  });
}

std::vector<Pose> SetDownPlaces::poses(const Eigen::Quaterniond& R_W_O) const {
  std::vector<Pose> turned;
  std::vector<Polygon2> prints;
  for (int k = 0; k < options_.turns; ++k) {
    const Eigen::AngleAxisd turn(2 * std::numbers::pi * k / options_.turns, Eigen::Vector3d::UnitZ());
    turned.push_back(standing(*task_.stone, turn * R_W_O, Eigen::Vector2d::Zero(), scene_.table_z));
    prints.push_back(footprint(task_.stone->pieces, turned.back()));
  }
  std::vector<Pose> all;
  for (const Eigen::Vector2d& spot : spots_)
    for (std::size_t k = 0; k < turned.size(); ++k)
      if (has_clearance(prints[k], spot)) {
        all.push_back(turned[k]);
        all.back().translation().head<2>() += spot;
      }
  return all;
}

}  // namespace stonestack::motion
