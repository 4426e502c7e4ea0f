#pragma once
#include <span>
#include <vector>

#include "detection/scene/depth_error.hpp"
#include "stonestack/detection/segment.hpp"

namespace stonestack::modelling {
using namespace geometry;

/// Smooth depth error that all views of one camera share, pixel by pixel; a plane is never part of it.
struct CameraError {
  int cell = 12;               ///< [px]
  int columns = 0, rows = 0;   ///< cells
  std::vector<double> offset;  ///< measured minus true depth at the middle of a cell, row by row [m]
  double sigma = 0.0;          ///< standard deviation of what the views share [m]; 0: nothing

  /// Measured minus true depth at a pixel [m].
  [[nodiscard]] double at(double u, double v) const;
};

/// Reads the error off the bare table, which is flat, in all views. Its variance is the mean product of what
/// two views show at one pixel, where these see different places of the table: each may be uneven in its own
/// way. It is carried to where objects hide the table by its correlation (kriging, Matern 3/2), and taken to
/// be the same at all distances.
/// @return no error for views of different sizes, where fewer than two show a table, and for views from one
/// pose
/// @throws InvalidArgument for an image that lacks depths.
[[nodiscard]] CameraError measure_camera_error(std::span<const DepthView> views,
                                               const SegmentOptions& options = {});

/// The image without that error.
[[nodiscard]] DepthImage without_error(DepthImage image, const CameraError& error);

}  // namespace stonestack::modelling
