#pragma once
#include <vector>

#include "geometry/polygon.hpp"
#include "motion/regrasp.hpp"

namespace stonestack::motion {

/// The stone with orientation R_W_O on the table, its centre of mass above `p_W_at`.
[[nodiscard]] Pose standing(const Stone& stone, const Eigen::Quaterniond& R_W_O,
                            const Eigen::Vector2d& p_W_at, double table_z);

/// Where on the table a stone can be set down for a while: on a grid around where it lies, clear of every
/// other object and of its target.
class SetDownPlaces {
 public:
  /// `scene` and `task` must outlive this.
  SetDownPlaces(const PlanningScene& scene, const PickAndPlaceTask& task, const RegraspOptions& options);
  /// Free poses of the stone standing with R_W_O, turned about the vertical: nearest place first.
  [[nodiscard]] std::vector<Pose> poses(const Eigen::Quaterniond& R_W_O) const;

 private:
  [[nodiscard]] bool has_clearance(const Polygon2& print, const Eigen::Vector2d& p_W_shift) const;

  const PlanningScene& scene_;
  const PickAndPlaceTask& task_;
  RegraspOptions options_;
  std::vector<Eigen::Vector2d> spots_;  ///< in W, nearest first
  std::vector<Polygon2> taken_;         ///< what is there already, seen from above
};

}  // namespace stonestack::motion
