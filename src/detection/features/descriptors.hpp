#pragma once
#include <span>

#include "detection/features/models.hpp"
#include "detection/features/triangulate.hpp"

namespace stonestack::detection {

// Each describes the surface around keypoints (indices into it) and drops keypoints whose description is not
// finite. Same result for any number of threads.

/// Signatures of histograms of orientations (Tombari 2010, PCL): 352 numbers, unit length.
[[nodiscard]] Features shot_features(const SurfacePoints& surface, std::span<const int> keypoints,
                                     double radius);

/// Fast point feature histograms (Rusu 2009, PCL): 33 numbers.
[[nodiscard]] Features fpfh_features(const SurfacePoints& surface, std::span<const int> keypoints,
                                     double radius);

/// Rotational projection statistics (Guo 2013, PCL), the paper's choice: 135 numbers. Needs triangles.
[[nodiscard]] Features rops_features(const TriangulatedSurface& mesh, std::span<const int> keypoints,
                                     double radius);

/// Intrinsic shape signatures (Zhong 2009), the paper's other choice: how the neighbourhood fills 66
/// directions by 5 distances around the keypoint's principal axes; 330 numbers, unit length. His four
/// possible frames are one here: signs come from the normal and from the heavier side.
[[nodiscard]] Features iss_features(const SurfacePoints& surface, std::span<const int> keypoints,
                                    double radius);

/// Keeps the keypoints whose rows are finite.
[[nodiscard]] Features finite_features(const SurfacePoints& surface, std::span<const int> keypoints,
                                       const Eigen::MatrixXf& rows);

}  // namespace stonestack::detection
