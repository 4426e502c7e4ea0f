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

/// Aligns scene to model, point to plane: seen points look for the nearest model sample, never the other way
/// round, because unseen parts of a model have nothing to match. Stops early when a step is below 0.01 mm.
[[nodiscard]] Refined refine_pose(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                                  std::span<const int> indices, const RefineOptions& options);

/// Indices of points within the model's bounding sphere at the pose (plus `margin`), at most `max` of them,
/// evenly thinned.
[[nodiscard]] std::vector<int> points_near(const DetectionModel& model, const Pose& T_C_O,
                                           const SurfacePoints& seen, double margin, int max);

}  // namespace stonestack::detection
