#pragma once
#include <string>
#include <string_view>

#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// Content of a PLY file that this library reads.
struct PlyContent {
  std::vector<Eigen::Vector3d> points;   ///< as in the file, possibly not finite
  std::vector<Eigen::Vector3f> normals;  ///< empty without nx, ny, nz
  std::vector<Eigen::Vector3i> faces;    ///< polygons as fans; indices are in range
  int width = 0;                         ///< from "comment width N" or "obj_info num_cols N"; 0: none
  int height = 0;                        ///< from "comment height N" or "obj_info num_rows N"
};

/// Strict PLY 1.0 (ASCII, binary of both byte orders). Counts are checked against the bytes left before
/// memory is taken; unknown elements and properties are skipped. `path` is for messages. Throws FileError.
[[nodiscard]] PlyContent parse_ply(const std::string& path, std::string_view content);

}  // namespace stonestack::geometry
