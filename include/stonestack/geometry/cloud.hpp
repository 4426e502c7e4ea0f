#pragma once
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Points, metres, in the frame that its owner's name states. Organised when width * height == points.size()
/// and height > 1; then a missing point is NaN.
struct Cloud {
  std::vector<Eigen::Vector3f> points;   ///< points [m]; NaN where an organised cloud has none
  std::vector<Eigen::Vector3f> normals;  ///< empty, or one unit vector a point
  int width = 0;                         ///< columns of an organised cloud; 0: not organised
  int height = 0;                        ///< rows of an organised cloud; 0: not organised
};

[[nodiscard]] Cloud transformed(const Cloud& cloud, const Pose& T_B_A);
/// Drops points that are not finite; the result is unorganised.
[[nodiscard]] Cloud without_gaps(const Cloud& cloud);

/// Reads PLY and PCD (ASCII, binary, binary_compressed), organised or not.
/// @throws FileError
[[nodiscard]] Cloud read_cloud(const std::string& path);
/// PLY (binary little-endian) or PCD (binary) by extension; organised clouds keep width and height (PCD, and
/// PLY by comments "width N" and "height N").
void write_cloud(const std::string& path, const Cloud& cloud);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
