#pragma once
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::detection {

/// Rendered view of one mesh, on every `step`-th pixel of the rectangle that holds it.
struct DrawnModel {
  int u0 = 0, v0 = 0;  ///< image pixel of the first drawn one
  int step = 1;
  int width = 0, height = 0;               ///< drawn pixels
  std::vector<float> z;                    ///< 0 where the mesh is not [m]
  std::vector<int> face;                   ///< hit face, where z > 0
  std::vector<Eigen::Vector3d> normals_C;  ///< of every face that was hit; of others not set

  /// Depth at a drawn pixel [m]; 0 where the mesh is not.
  [[nodiscard]] float depth(int x, int y) const {
    const bool inside = x >= 0 && y >= 0 && x < width && y < height;
    return inside ? z[static_cast<std::size_t>(y * width + x)] : 0.0F;
  }
};

/// Draws by scan conversion: tens of microseconds for 500 faces, and no tree to build for a pose that is
/// tried once. Empty when the mesh is outside the image or not wholly in front of the camera.
[[nodiscard]] DrawnModel draw_model(const Mesh& mesh_O, const std::vector<Eigen::Vector3d>& normals_O,
                                    const Pose& T_C_O, const CameraIntrinsics& camera, int step);

/// Normal of the drawn mesh, in the camera frame and towards it, over as many pixels as normals of a depth
/// image are taken (seen_normal): fine relief is smoothed in both alike. The hit face's own where an edge is
/// near. Only where the mesh is.
[[nodiscard]] Eigen::Vector3d drawn_normal(const DrawnModel& drawn, const CameraIntrinsics& camera, int x,
                                           int y);

}  // namespace stonestack::detection
