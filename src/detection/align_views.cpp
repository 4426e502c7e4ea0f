#include "detection/align_views.hpp"

#include <cmath>
#include <numeric>

#include "detection/refine.hpp"

namespace stonestack {
namespace {

constexpr float kCell = 0.005F;       // m, of the field over the earlier surface
constexpr float kBand = 0.020F;       // m
constexpr float kWidest = 1.8F;       // m: a wider scene is not aligned
constexpr int kMostPoints = 6000;     // of the further view
constexpr float kTableStep = 0.010F;  // m, between the points that stand for the table
constexpr int kFewestShared = 300;    // correspondences

RefineOptions alignment_steps() {
  return {15, 0.006, 0.003, 0.001, 0.9};  // tight: opposite sides of a stone are near each other, too
}

/// The points with some of the table below them.
SurfacePoints with_table(const ViewSurface& seen, const Eigen::AlignedBox3f& box) {
  SurfacePoints out = seen.points;
  if (!seen.table) return out;
  const Eigen::Vector3f n = seen.table->normal.cast<float>(), x = n.unitOrthogonal(), y = n.cross(x);
  const Eigen::Vector3f centre =
      box.center() - static_cast<float>(seen.table->distance(box.center().cast<double>())) * n;
  const int reach = static_cast<int>(0.5F * box.sizes().norm() / kTableStep);
  for (int i = -reach; i <= reach; ++i)
    for (int k = -reach; k <= reach; ++k) {
      out.points.emplace_back(centre + kTableStep * (static_cast<float>(i) * x + static_cast<float>(k) * y));
      out.normals.push_back(n);
      out.areas.push_back(0.0F);
    }
  return out;
}

}  // namespace

Pose alignment(const ViewSurface& earlier, const ViewSurface& further, const DetectionOptions& options) {
  if (options.align_shift <= 0 || earlier.points.points.size() < 100 || further.points.points.size() < 100)
    return Pose::Identity();
  Eigen::AlignedBox3f box;
  for (const auto& p : earlier.points.points) box.extend(p);
  if (box.sizes().maxCoeff() > kWidest) return Pose::Identity();
  const bool tables = earlier.table && further.table;
  const SurfacePoints earlier_C = tables ? with_table(earlier, box) : earlier.points;
  const SurfacePoints further_C = tables ? with_table(further, box) : further.points;
  const SurfaceField field(earlier_C.points, kCell, kBand);
  const RefineTarget target{earlier_C, field, box.center().cast<double>()};
  std::vector<int> some;
  const auto count = static_cast<int>(further_C.points.size()), most = std::min(count, kMostPoints);
  for (int i = 0; i < most; ++i) some.push_back(static_cast<int>(static_cast<long>(i) * count / most));
  // The earlier surface is the model, in a frame of its own that starts as C: what it is found at, inverted,
  // is the way of the further points.
  const Refined refined = refine_pose(target, Pose::Identity(), further_C, some, alignment_steps());
  if (refined.correspondences < kFewestShared || !is_valid(refined.T_C_O)) return Pose::Identity();
  const Pose off = refined.T_C_O.inverse();
  const Eigen::Vector3d centre = target.centre;
  const double shift = (off * centre - centre).norm(), turn = Eigen::AngleAxisd(off.linear()).angle();
  if (shift > options.align_shift || turn > options.align_turn) return Pose::Identity();
  return off;
}

}  // namespace stonestack
