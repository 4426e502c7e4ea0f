#pragma once
#include <span>
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// How to refine.
struct RefineOptions {
  int iterations = 12;
  double gate_first = 0.015;  ///< furthest correspondence, at first [m]
  double gate_last = 0.005;   ///< at last [m]
  double robust = 0.002;      ///< residual at which a point counts half [m]
  double min_cosine = 0.5;    ///< between seen and model normal, in the second half
};

/// A refined pose.
struct Refined {
  Pose T_C_O = Pose::Identity();
  int correspondences = 0;
  double rms = 0.0;  ///< robustly weighted point-to-plane residual [m]
};

/// Aligns scene to model, point to plane: each seen point is matched to the nearest model sample, never the
/// reverse round, because unseen parts of a model have nothing to match. Stops early when a step is below
/// 0.01 mm.
[[nodiscard]] Refined refine_pose(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                                  std::span<const int> indices, const RefineOptions& options);

/// Indices of points within the model's bounding sphere at the pose (plus `margin`), at most `max` of them,
/// evenly thinned.
[[nodiscard]] std::vector<int> points_near(const DetectionModel& model, const Pose& T_C_O,
                                           const SurfacePoints& seen, double margin, int max);

/// Picks likewise for a pose about which no other points are than `among`, ascending.
[[nodiscard]] std::vector<int> points_near(const DetectionModel& model, const Pose& T_C_O,
                                           const SurfacePoints& seen, double margin, int max,
                                           std::span<const int> among);

/// Points about one pose of a model after another: collected anew only where the last ones do not do. Keeps
/// references to both.
class PointsAround {
 public:
  PointsAround(const DetectionModel& model, const SurfacePoints& seen) : model_(model), seen_(seen) {}

  /// Indices, ascending, of all points within the model's bounding sphere at the pose (plus `margin`), and of
  /// some others.
  [[nodiscard]] const std::vector<int>& of(const Pose& T_C_O, double margin);

 private:
  const DetectionModel& model_;
  const SurfacePoints& seen_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 0.0;
  std::vector<int> points_;
};

}  // namespace stonestack::detection
