#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/convex_pieces.hpp"
#include "geometry/polygon.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr double kRestSame = 0.97;  // cosine (14 deg): faces this similar give one resting pose

bool is_listed(const Eigen::Vector3d& n_O_up, const std::vector<Eigen::Vector3d>& list) {
  return std::any_of(list.begin(), list.end(),
                     [&](const Eigen::Vector3d& n) { return n_O_up.dot(n) > kRestSame; });
}

/// A resting pose: the up direction in the stone's frame.
struct Stand {
  Eigen::Vector3d n_O_up;
  double margin = 0.0;  // m
  double height = 0.0;  // m, of the centre of mass
  [[nodiscard]] double tilt() const { return std::atan2(margin, height); }
};

/// Standing on the hull's face with the outward normal -`n_O_up`.
Stand stand_on(const Mesh& hull, const Eigen::Vector3d& p_O_M, const Eigen::Vector3d& n_O_up, double flat) {
  double lowest = n_O_up.dot(hull.vertices.front());
  for (const auto& v : hull.vertices) lowest = std::min(lowest, n_O_up.dot(v));
  const Eigen::Vector3d x = n_O_up.unitOrthogonal(), y = n_O_up.cross(x);
  std::vector<Eigen::Vector2d> base_points;
  for (const auto& v : hull.vertices)
    if (n_O_up.dot(v) - lowest <= flat) base_points.emplace_back(x.dot(v), y.dot(v));
  return {n_O_up, margin(convex_hull(std::move(base_points)), {x.dot(p_O_M), y.dot(p_O_M)}),
          n_O_up.dot(p_O_M) - lowest};
}

}  // namespace

std::vector<RestPose> rest_poses(const Stone& stone, const RegraspOptions& options) {
  require(!stone.scan.vertices.empty() && stone.mass.mass > 0.0, "stone ", stone.name,
          " needs a scan and a mass to find how it can stand");
  const Mesh hull = convex_hull(stone.scan);
  std::vector<Stand> stands;
  for (const auto& n : face_normals(hull)) {
    if (n.norm() < 0.5) continue;
    const Stand stand = stand_on(hull, stone.mass.p_O_M, -n, options.flat);
    if (stand.margin >= options.rest_margin && stand.tilt() >= options.rest_tilt) stands.push_back(stand);
  }
  std::stable_sort(stands.begin(), stands.end(),
                   [](const Stand& a, const Stand& b) { return a.margin > b.margin; });
  std::vector<Stand> kept;
  for (const auto& stand : stands)
    if (!is_listed(stand.n_O_up, options.n_O_not_up) &&
        std::none_of(kept.begin(), kept.end(),
                     [&](const Stand& k) { return k.n_O_up.dot(stand.n_O_up) > kRestSame; }))
      kept.push_back(stand);
  std::vector<RestPose> all;
  for (const auto& stand : kept)
    all.push_back({Eigen::Quaterniond::FromTwoVectors(stand.n_O_up, Eigen::Vector3d::UnitZ()), stand.margin,
                   stand.tilt()});
  return all;
}

}  // namespace stonestack::motion
