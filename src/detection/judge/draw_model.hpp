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
  std::vector<Eigen::Vector3d> normals_C;  ///< of every face of the mesh
};

/// Draws by scan conversion: tens of microseconds for 500 faces, and no tree to build for a pose that is
/// tried once. Empty when the mesh is outside the image or not wholly in front of the camera.
[[nodiscard]] DrawnModel draw_model(const Mesh& mesh_O, const std::vector<Eigen::Vector3d>& normals_O,
                                    const Pose& T_C_O, const CameraIntrinsics& camera, int step);

}  // namespace stonestack::detection
