#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/detection/segment.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::detection {

/// Surface that one depth image shows above the table. V is the camera.
struct ObjectSurface {
  DepthImage depth;                     ///< smoothed; 0 where unknown or out of range
  std::optional<Plane> table_V;         ///< normal towards the camera; empty: nothing else was made
  double lowest = 0.0;                  ///< height above the table from which on surface is an object's [m]
  std::vector<Eigen::Vector3f> points;  ///< a pixel each, in V; zero without a depth
  std::vector<char> shown;              ///< a flag a pixel: surface of an object
  std::string note;                     ///< why there is no table, for a person; empty otherwise

  /// Mean focal length [px].
  [[nodiscard]] double focal_length() const { return 0.5 * (depth.camera.fx + depth.camera.fy); }
};

/// The options of detection that the steps read which segmentation shares with it.
[[nodiscard]] DetectionOptions detection_options(const SegmentOptions& options);

/// Smooths the image, finds the table, and marks what stands on the part of it that is seen: surface higher
/// than 6 mm, or than four times the noise about the table, and above the seen table's outline.
[[nodiscard]] ObjectSurface object_surface(const DepthImage& image, const std::optional<Plane>& expected_V,
                                           const SegmentOptions& options);

}  // namespace stonestack::detection
