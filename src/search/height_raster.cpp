#include "search/height_raster.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::search {
namespace {

/// Nodes of one axis between two coordinates (in cells from the centre), kept inside the raster.
struct NodeRange {
  int first, last;
};
/// A value known to be within the range of int; std::floor is a call where SSE 4.1 may not be counted on.
int floor_of(double x) {
  const int k = static_cast<int>(x);
  return k - (x < k ? 1 : 0);
}
int ceil_of(double x) {
  const int k = static_cast<int>(x);
  return k + (x > k ? 1 : 0);
}
NodeRange nodes_between(double low, double high, int half) {
  const double limit = half;
  return {ceil_of(std::clamp(low, -limit, limit + 1)), floor_of(std::clamp(high, -limit - 1, limit))};
}

}  // namespace

HeightRaster::HeightRaster(const Eigen::Vector2d& centre_in, double cell_in, int half_in)
    : centre(centre_in),
      cell(cell_in),
      half(half_in),
      stride(2 * half_in + 1),
      z(static_cast<std::size_t>(stride) * static_cast<std::size_t>(stride), kNoSurface) {}

void raise_to(HeightRaster& raster, std::span<const Eigen::Vector3d> vertices,
              std::span<const Eigen::Vector3i> faces, Winding which) {
  const double per_cell = 1.0 / raster.cell;
  const auto in_cells = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    return (p.head<2>() - raster.centre) * per_cell;
  };
  for (const Eigen::Vector3i& face : faces) {
    const Eigen::Vector3d& a = vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector3d& b = vertices[static_cast<std::size_t>(face[1])];
    const Eigen::Vector3d& c = vertices[static_cast<std::size_t>(face[2])];
    const Eigen::Vector2d pa = in_cells(a), pb = in_cells(b), pc = in_cells(c);
    const double twice_area = (pb.x() - pa.x()) * (pc.y() - pa.y()) - (pb.y() - pa.y()) * (pc.x() - pa.x());
    if (std::abs(twice_area) < 1e-9) continue;
    if (which != Winding::kAny && (twice_area > 0.0) != (which == Winding::kCounterclockwise)) continue;
    const NodeRange rows =
        nodes_between(std::min({pa.y(), pb.y(), pc.y()}), std::max({pa.y(), pb.y(), pc.y()}), raster.half);
    if (rows.first > rows.last) continue;
    const NodeRange columns =
        nodes_between(std::min({pa.x(), pb.x(), pc.x()}), std::max({pa.x(), pb.x(), pc.x()}), raster.half);
    const double inverse = 1.0 / twice_area;
    for (int j = rows.first; j <= rows.last; ++j) {
      for (int i = columns.first; i <= columns.last; ++i) {
        // Barycentric weights of b and c; a rim of 1e-9 keeps nodes on shared edges.
        const double x = i - pa.x(), y = j - pa.y();
        const double wb = (x * (pc.y() - pa.y()) - y * (pc.x() - pa.x())) * inverse;
        const double wc = (y * (pb.x() - pa.x()) - x * (pb.y() - pa.y())) * inverse;
        if (wb < -1e-9 || wc < -1e-9 || wb + wc > 1.0 + 1e-9) continue;
        float& height = raster.z[static_cast<std::size_t>(raster.index(i, j))];
        height = std::max(height, static_cast<float>(a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z())));
      }
    }
  }
}

}  // namespace stonestack::search
