#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "search/height_raster.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack {

/// What a new stone may come to lie on, seen from above: heights in W and, per node, whether the surface may
/// be touched. What must not be touched (lower stones, the table) is raised by a clearance.
struct TopSurface {
  HeightRaster heights;
  std::vector<std::uint8_t> may_touch;  ///< 1: the top stone (or the table for an empty stack)
};

/// The underside of a stone in one orientation: nodes on multiples of the cell from its centre of mass, near
/// its lowest point only.
struct Underside {
  Eigen::Matrix3d R_W_O;
  double lowest = 0.0;    ///< m, lowest point under the centre of mass (negative)
  std::vector<int> step;  ///< index from the centre's node in a raster of the given stride
  std::vector<float> x, y, z;
};

/// Which nodes of the underside count: up to `cut` above the lowest point.
struct UndersideOptions {
  double cell = 0.004;
  int stride = 0;  ///< of the TopSurface that it will be laid over
  double cut = 0.035;
};

/// `vertices_M`: of the scan, relative to the centre of mass, axes of O.
[[nodiscard]] Underside make_underside(const std::vector<Eigen::Vector3d>& vertices_M,
                                       const std::vector<Eigen::Vector3i>& faces,
                                       const Eigen::Matrix3d& R_W_O, const UndersideOptions& options);

/// The gap D(x, y) = top height - underside height, x and y from the centre of mass. Buffers are reused.
struct GapField {
  std::vector<float> x, y, d;
  std::vector<int> node;  ///< of the TopSurface
  float highest = kNoSurface;
  std::size_t size = 0;  ///< entries that count; the rest pads to whole blocks
};
/// Lays the underside over the surface with the centre of mass above node (i, j), which must be at least the
/// underside's extent away from the raster's rim. Keeps cells within `active` of the largest gap: the others
/// cannot touch while the tilt stays small.
void lay(const TopSurface& top, const Underside& underside, int i, int j, double active, GapField* field);

/// The plane c + a x + b y that rests on the gap field: the least height of the centre of mass, with tilt
/// free.
struct GapRest {
  bool rests = false;       ///< three cells carry it and they enclose the centre of mass; false: it tips over
  bool clean = false;       ///< and all three may be touched
  double height = 0.0;      ///< c, m
  double a = 0.0, b = 0.0;  ///< tilt that is still needed, rise over run
  std::array<int, 3> cells{};  ///< into the field
};
/// min c subject to c + a x + b y >= D everywhere: a linear programme in three variables, by the dual simplex
/// method. Its basis is the upper hull facet of D above the centre of mass, so the contacts enclose it. Tilts
/// up to about `largest_slope`.
[[nodiscard]] GapRest solve_rest(const GapField& field, const TopSurface& top, double largest_slope);

/// How well a resting pose is carried.
struct GapContact {
  double margin = 0.0;  ///< m: centre of mass to the rim of the cells that nearly touch
  double height = 0.0;  ///< m: centre of mass over the mean contact
};
/// Cells within `tolerance` of the resting plane count as touching.
[[nodiscard]] GapContact contact_of(const GapField& field, const GapRest& rest, const TopSurface& top,
                                    double tolerance);

}  // namespace stonestack
