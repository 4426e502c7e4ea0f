#pragma once
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::detection {

struct DetectionOptions;

/// Smooth error of a depth image, from the image itself: the bare table is flat, so what it deviates is the
/// camera's fault. Depth cameras err smoothly over tens of pixels (half a millimetre, say), and that does not
/// average out over a stone; beside the stone it can be read off, and how far it carries, too.
struct DepthError {
  int cell = 12;                ///< [px]
  int columns = 0, rows = 0;    ///< cells
  std::vector<float> offset;    ///< mean of measured minus flat depth in a cell of bare table [m]
  std::vector<int> count;       ///< pixels of bare table in it
  double sigma = 0.0005;        ///< standard deviation of the smooth error ... [m]
  double length = 32.0;         ///< ... over which it is correlated [px]
  double pixel_noise = 0.0006;  ///< of a smoothed pixel, as if pixels erred independently [m]

  [[nodiscard]] int cell_at(double u, double v) const;
  /// Covariance of the smooth error of two places `distance` px apart, m^2 (Matern 3/2).
  [[nodiscard]] double covariance(double distance) const;
};

/// No table: the assumption of the options.
[[nodiscard]] DepthError assumed_depth_error(const CameraIntrinsics& camera, const DetectionOptions& options);

/// Reads the error off the table of a smoothed image. Deviation, reach and noise come from how the cells'
/// offsets resemble each other over distance (autocovariance); with too little table they stay as assumed.
[[nodiscard]] DepthError measure_depth_error(const DepthImage& depth, const Plane& table_V,
                                             const DetectionOptions& options);

}  // namespace stonestack::detection
