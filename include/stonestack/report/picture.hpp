#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::report {

/// 8-bit RGB, row by row.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// A mesh to draw.
struct DrawnMesh {
  Mesh mesh;
  Pose T_W_A = Pose::Identity();
  Eigen::Vector3d colour{0.75, 0.72, 0.66};  ///< 0..1
};

/// Where the picture is taken from.
struct View {
  Eigen::Vector3d p_W_eye{1.2, -0.8, 0.7};
  Eigen::Vector3d p_W_target{0.7, 0.28, 0.15};
  double angle = 0.6;  ///< vertical field of view [rad]
  int width = 1200, height = 900;
};

/// Soft-lit, with shadows and ambient occlusion, on a table; drawn with rays, without a display.
/// Deterministic.
[[nodiscard]] Picture draw(const std::vector<DrawnMesh>& meshes, const View& view);
void write_png(const std::string& path, const Picture& picture);

}  // namespace stonestack::report

#pragma GCC visibility pop
