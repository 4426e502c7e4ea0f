#include "detection/scene/align_views.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "detection/constants.hpp"
#include "geometry/small_motion.hpp"

namespace stonestack::detection {
namespace {

constexpr double kTableSigma = 0.0003;  // m, of a table's height at a corner: its smooth error averages out
constexpr double kTableReach = 0.20;    // m, of three corners around the point on the camera's axis
constexpr int kSteps = 4;
constexpr int kFewestPixels = 3000;  // of bare table: with fewer it is where it was expected, not seen

bool shows_table(const SeenView& view) {
  return view.table_V &&
         std::accumulate(view.error.count.begin(), view.error.count.end(), 0) >= kFewestPixels;
}

/// Three points of the plane, around where the optical axis meets it.
std::vector<Eigen::Vector3d> corners(const Plane& table_V) {
  std::vector<Eigen::Vector3d> points;
  const double slope = table_V.normal.z();
  const double z = std::abs(slope) > 0.05 ? table_V.offset / slope : 0.0;
  const Eigen::Vector3d ahead(0, 0, z > 0.1 && z < 3.0 ? z : 0.7);
  const Eigen::Vector3d on_table = ahead - table_V.distance(ahead) * table_V.normal;
  const Eigen::Vector3d x = table_V.normal.unitOrthogonal(), y = table_V.normal.cross(x);
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0943951 * k;
    points.emplace_back(on_table + kTableReach * (std::cos(angle) * x + std::sin(angle) * y));
  }
  return points;
}

}  // namespace

ViewConstraint view_constraint(const std::optional<Plane>& table_C, const SeenView& view, const Pose& T_C_V) {
  ViewConstraint out;
  const double shift = std::max(kViewShift, 1e-6), turn = std::max(kViewTurn, 1e-6);
  const Pose off = view.T_C_V_reported.inverse() * T_C_V;
  Eigen::Matrix<double, 6, 1> x, precision;
  x << off.translation(), rotation_vector(off.linear());
  precision << Eigen::Vector3d::Constant(1.0 / (shift * shift)),
      Eigen::Vector3d::Constant(1.0 / (turn * turn));
  out.H.diagonal() = precision;
  out.g = precision.cwiseProduct(x);
  if (!table_C || !shows_table(view)) return out;
  const Eigen::Vector3d n_V = T_C_V.linear().transpose() * table_C->normal;
  const double weight = 1.0 / (kTableSigma * kTableSigma);
  for (const auto& p_V : corners(*view.table_V)) {
    Eigen::Matrix<double, 6, 1> J;
    J << n_V, p_V.cross(n_V);
    out.H += weight * J * J.transpose();
    out.g += weight * table_C->distance(T_C_V * p_V) * J;
  }
  return out;
}

Pose aligned_view(const std::optional<Plane>& table_C, const SeenView& view) {
  Pose T_C_V = view.T_C_V_reported;
  for (int step = 0; step < kSteps; ++step) {
    const ViewConstraint held = view_constraint(table_C, view, T_C_V);
    const Eigen::Matrix<double, 6, 1> x = -held.H.ldlt().solve(held.g);
    T_C_V = orthonormal(T_C_V * small_motion(x));
  }
  return T_C_V;
}

std::optional<Plane> seen_table(const DetectionScene& scene) {
  if (scene.views.empty() || !shows_table(scene.views.front())) return {};
  return scene.table_C;
}

}  // namespace stonestack::detection
