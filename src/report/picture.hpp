#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/stone/catalogue.hpp"

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
  bool solid = true;                         ///< false: a line of a drawing, which casts no shadow
  bool grain = false;  ///< true: faces differ a little in brightness, so that edges are seen
};

/// Where the picture is taken from.
struct View {
  Eigen::Vector3d p_W_eye{1.2, -0.8, 0.7};
  Eigen::Vector3d p_W_target{0.7, 0.28, 0.15};
  double angle = 0.6;  ///< vertical field of view [rad]
  int width = 1200, height = 900;
  double table = 1.6;  ///< half of the table's edge [m]
};

/// Soft-lit, with shadows and ambient occlusion, on a table; drawn with rays, without a display.
/// Deterministic.
[[nodiscard]] Picture draw(const std::vector<DrawnMesh>& meshes, const View& view);
/// Content of a PNG file.
[[nodiscard]] std::string png_bytes(const Picture& picture);
void write_png(const std::string& path, const Picture& picture);

/// Meshes of stones at poses in stone-like colours, one a stone.
[[nodiscard]] std::vector<DrawnMesh> drawn_stones(const Catalogue& catalogue,
                                                  const std::vector<PlacedStone>& stones);
/// Contact shapes for a report or a picture. Unlike those of `make_contact_shapes` they are made to the end
/// after Ctrl-C, too: what was done is then still to be shown.
[[nodiscard]] ShapeList shapes_for_output(const std::vector<Stone>& stones);
/// A view of everything at the site: from the front, high enough to see the table.
[[nodiscard]] View view_of_site(const Eigen::Vector2d& site, double top_height);

}  // namespace stonestack::report
